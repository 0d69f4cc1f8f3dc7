"""Reads answers in every representation by the programs that people use: NumPy, SciPy, pandas, Octave, R, DuckDB, the
tools of HDF5, the csv and json modules. Every number must equal that of the JSON answer to the last bit, including the sign of zero.

usage: readback.py BUILD
Leaves to others: whether the JSON is right (tests/wire, tests/laws). Invariant: skipped tests are reported.
"""
import csv
import io
import json
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile

from rule import OCTAVE, check, optional, skip, summary
from servers import daemon

DUCKDB = pathlib.Path("build/readers/node_modules/@duckdb/node-api/lib/index.js")
HYPARQUET = pathlib.Path("build/spectral/node_modules/hyparquet/src/node.js")  # brought by npm for rules/openapi too
numpy = optional("numpy")
h5py = optional("h5py")
pandas = optional("pandas")
tables = optional("pyarrow") or optional("fastparquet")  # what pandas reads Parquet with
scipy = optional("scipy.io")

FOUR = '"pendulum":{"L":[2,1.5,0.75,1.25],"m":[1,1,1,0.1],"S":[[1,0,0,0],[1,1,0,0],[1,1,1,0],[1,1,0,1]]}'
TWO = '"pendulum":{"length":[1,1],"mass":[1,1],"parent":[0,1]}'
ONE = '"pendulum":{"length":[0.7],"mass":[1.3],"parent":[0]}'
ALL = '"output":["phi","phid","phidd","theta","thetad","z","zd","lambda","energy"]'
REQUESTS = {
    "the paper's example": ("/v1/trajectories", f'{{{FOUR},"times":{{"start":0,"stop":5,"step":0.01}},{ALL}}}'),
    "its default output": ("/v1/trajectories", f'{{{FOUR},"times":{{"start":0,"stop":5,"step":0.01}}}}'),
    "one arm, one instant": ("/v1/trajectories", f'{{{ONE},"times":[0.25],{ALL}}}'),
    "backwards, unevenly": ("/v1/trajectories", f'{{{FOUR},"times":[0,-0.1,-0.25,-3],{ALL}}}'),
    "longer than a block": ("/v1/trajectories", f'{{{FOUR},"times":{{"start":0,"stop":20,"count":20001}}}}'),
    "a section past its horizon": ("/v1/sections", f'{{{TWO},"initial":{{"theta":[2,2.5]}},"duration":20,"section":{{"arm":1,"theta":0}}}}'),
    "an ensemble past its horizons": ("/v1/ensembles", f'{{{TWO},"states":[{{"theta":[2,2.5]}},{{"theta":[0.1,0]}}],"duration":20,'
                                      '"observables":["horizon"]}'),
    "states": ("/v1/forces", f'{{{FOUR},"states":[{{"phi":[1,2,3,4]}},{{"theta":[0.1,0,0,0],"thetad":[1,1e-300,-1,0]}}]}}'),
}


def bits(value):
    return struct.pack("<d", value)


class Columns(dict):
    """Name -> rows of numbers; beside them the warnings, which every representation has to repeat."""
    warnings = []


def columns_of(answer):
    """The columns of a JSON answer: z becomes z_re and z_im, energy its parts."""
    columns = Columns()
    columns.warnings = answer.get("warnings", [])
    for name, value in answer.items():
        if name not in WORDS:
            parts = {f"{name}_{part}": rows for part, rows in value.items()} if isinstance(value, dict) else {name: value}
            columns |= {part: [row if isinstance(row, list) else [row] for row in rows] for part, rows in parts.items()}
    return columns


WORDS = {"stats", "warnings"}  # members that are no columns of numbers


def warned(what, told, columns):
    check(f"{what}: warnings", list(told) == columns.warnings, f"{told} are not {columns.warnings}")


def rows_of(columns):
    """The same as rows of all columns side by side."""
    return [[number for part in parts for number in part] for parts in zip(*columns.values())]


def same(what, wanted, rows):
    """Both are lists of rows of doubles."""
    rows = [list(row) for row in rows]
    if [len(row) for row in rows] != [len(row) for row in wanted]:
        check(what, False, f"{len(rows)} rows, expected {len(wanted)}")
        return
    wrong = [(i, k) for i, row in enumerate(wanted) for k, number in enumerate(row) if bits(number) != bits(rows[i][k])]
    check(what, not wrong, f"{len(wrong)} numbers differ, the first in row {wrong[0][0]}, column {wrong[0][1]}" if wrong else "")


def names_of(columns):
    """What the columns of a table are called."""
    return [f"{name}_{k + 1}" if len(rows[0]) > 1 or name not in SCALARS else name for name, rows in columns.items() for k in range(len(rows[0]))]


def same_in_turn(what, columns, numbers):
    """The numbers of one column after the other."""
    same(what, [[number for rows in columns.values() for row in rows for number in row]], [numbers])


def program(what, ending, data, command, script, *words):
    """The doubles that a program writes into the second of its two files, of an answer in the first; and what it prints."""
    with tempfile.TemporaryDirectory() as directory:
        file, out, own = (pathlib.Path(directory, name) for name in (f"answer.{ending}", "numbers", "read.mjs"))
        file.write_bytes(data)
        own.write_text(script)
        run = subprocess.run([*command, own, file, out, *words], capture_output=True, text=True, timeout=600)
        check(f"{what}: read", not run.returncode, run.stdout + run.stderr[-500:])
        numbers = out.read_bytes() if not run.returncode else b""
    return [number for (number,) in struct.iter_unpack("<d", numbers)], run.stdout


def in_rows(numbers, columns):
    width = sum(len(rows[0]) for rows in columns.values())
    return [numbers[i:i + width] for i in range(0, len(numbers), width)]


# --- readers: bytes of an answer and its header fields, the columns of the JSON ---

def read_csv(what, data, headers, columns):
    header, *rows = csv.reader(io.StringIO(data.decode(), newline=""))
    words = [line.removeprefix("# warning: ") for line in data.decode().splitlines() if line.startswith("# ")]
    warned(what, words, columns)
    rows = rows[:len(rows) - len(words)]  # the last lines are words about the numbers above
    check(f"{what}: the header of the CSV", header == names_of(columns), f"{header} is not {names_of(columns)}")
    same(what, rows_of(columns), [[float(cell) for cell in row] for row in rows])


SCALARS = {"t", "direction", "member", "status", "horizon", "energy_kinetic", "energy_potential", "energy_total"}


def read_ndjson(what, data, headers, columns):
    lines = data.decode().splitlines()
    warned(what, json.loads(lines[-1]).get("warnings", []), columns)
    parts = [columns_of({name: {part: [rows] for part, rows in value.items()} if isinstance(value, dict) else [value]
                         for name, value in json.loads(line).items()}) for line in lines if '"stats"' not in line[:9]]
    same(what, rows_of(columns), [[number for rows in part.values() for number in rows[0]] for part in parts])


def read_octets(what, data, headers, columns):
    names = [f"{name}[{len(rows[0])}]" if name not in SCALARS else name for name, rows in columns.items()]
    if "X-Warning" in headers or not columns.warnings:  # behind a stream they are trailers, which this client does not read
        warned(what, headers.get_all("X-Warning") or [], columns)
    check(f"{what}: X-Columns", headers.get("X-Columns") == ",".join(names), headers.get("X-Columns"))
    width = sum(int((re.search(r"\[(\d+)\]", name) or [0, 1])[1]) for name in names)
    same(what, rows_of(columns), numpy.frombuffer(data, "<f8").reshape(-1, width).tolist())


def compare_arrays(what, arrays, columns):
    """arrays: name -> nested lists of rows; complex ones hold two columns of the JSON each."""
    wanted = {name: rows for name, rows in columns.items() if not name.endswith("_im")}
    wanted = {name.removesuffix("_re"): rows for name, rows in wanted.items()}
    check(f"{what}: names", set(arrays) == set(wanted), f"{sorted(arrays)} are not {sorted(wanted)}")
    for name in set(arrays) & set(wanted):
        if f"{name}_re" in columns:
            same(f"{what}: {name}, real", columns[f"{name}_re"], [[z.real for z in row] for row in arrays[name]])
            same(f"{what}: {name}, imaginary", columns[f"{name}_im"], [[z.imag for z in row] for row in arrays[name]])
        else:
            same(f"{what}: {name}", columns[name], arrays[name])


def has_method(what):
    """Whether the statistics name the method: of trajectories alone they do."""
    return not what.startswith(("states", "a section", "an ensemble"))


def read_npz(what, data, headers, columns):
    with numpy.load(io.BytesIO(data), allow_pickle=False) as file:
        warned(what, file["warnings"].tolist() if "warnings" in file.files else [], columns)
        arrays = {name: file[name].reshape(len(file[name]), -1).tolist() for name in file.files
                  if not name.startswith("stats_") and name != "warnings"}
        check(f"{what}: statistics", not has_method(what) or file["stats_method"] == "taylor" and
              re.fullmatch("[0-9a-f]{16}", str(file["stats_engine"])), file.files)
    compare_arrays(what, arrays, columns)


def read_parquet(what, data, headers, columns):
    frame = pandas.read_parquet(io.BytesIO(data))
    same(what, rows_of(columns), frame.to_numpy().tolist())


def read_hdf5(what, data, headers, columns):
    with h5py.File(io.BytesIO(data)) as file:
        warned(what, [word.decode() for word in file.attrs.get("warnings", [])], columns)
        check(f"{what}: statistics", not has_method(what) or file.attrs["method"] == b"taylor" and
              re.fullmatch("[0-9a-f]{16}", file.attrs["engine"].decode()), dict(file.attrs))
        check(f"{what}: names", set(file) == set(columns), f"{sorted(file)} are not {sorted(columns)}")
        for name in set(file) & set(columns):
            same(f"{what}: {name}", columns[name], file[name][()].reshape(len(file[name]), -1).tolist())


def read_h5dump(what, data, headers, columns):
    """The HDF Group's own tool, a column at a time."""
    with tempfile.TemporaryDirectory() as directory:
        file, out = pathlib.Path(directory, "answer.h5"), pathlib.Path(directory, "numbers")
        file.write_bytes(data)
        for name, rows in columns.items():
            run = subprocess.run(["h5dump", "-d", f"/{name}", "-b", "LE", "-o", out, file], capture_output=True, text=True, timeout=600)
            check(f"{what}: {name}", not run.returncode, run.stderr[-500:])
            numbers = [number for (number,) in struct.iter_unpack("<d", out.read_bytes())]
            same(f"{what}: {name}", [[number for row in rows for number in row]], [numbers])


OCTAVE_ARRAYS = """
s = load(argv(){1});
out = fopen(argv(){2}, 'w');
for name = strsplit(argv(){3}, ',')
  fwrite(out, s.(name{1}), 'double');
end
fclose(out);
"""


def read_hdf5_octave(what, data, headers, columns):
    """Octave's own load: the last axis comes first there, and warnings are attributes, which it leaves alone."""
    same_in_turn(what, columns, program(what, "h5", data, [OCTAVE, "--norc", "--quiet"], OCTAVE_ARRAYS, ",".join(columns))[0])


PARQUET = """
import { writeFileSync } from "node:fs";
const { asyncBufferFromFile, parquetReadObjects } = await import(process.argv[4]);
const rows = await parquetReadObjects({ file: await asyncBufferFromFile(process.argv[2]) });
writeFileSync(process.argv[3], Float64Array.from(rows.flatMap(Object.values)));
console.log(JSON.stringify([rows.length, Object.keys(rows[0] ?? {})]));
"""


def read_parquet_node(what, data, headers, columns):
    numbers, told = program(what, "parquet", data, ["node"], PARQUET, HYPARQUET.resolve())
    count, names = json.loads(told or "[0, []]")
    check(f"{what}: the names of the columns", names == names_of(columns), f"{names} are not {names_of(columns)}")
    check(f"{what}: rows", len(numbers) == count * len(names), f"{len(numbers)} numbers in {count} rows")
    same(what, rows_of(columns), in_rows(numbers, columns))


SELECT = """
import { writeFileSync } from "node:fs";
const { DuckDBInstance } = await import(process.argv[4]);
const session = await (await DuckDBInstance.create(":memory:")).connect();
const found = await session.runAndReadAll(`SELECT * FROM ${process.argv[5].replace("FILE", process.argv[2])}`);
if (found.columnTypes().some((type) => String(type) !== "DOUBLE" && String(type) !== "BIGINT")) throw found.columnTypes().join();
writeFileSync(process.argv[3], Float64Array.from(found.getRows().flat().map(Number)));
"""


def read_parquet_duckdb(what, data, headers, columns):
    same(what, rows_of(columns), in_rows(program(what, "parquet", data, ["node"], SELECT, DUCKDB.resolve(), "'FILE'")[0], columns))


def read_csv_duckdb(what, data, headers, columns):
    told, _ = program(what, "csv", data, ["node"], SELECT, DUCKDB.resolve(), "read_csv('FILE', comment = '#')")
    same(what, positive(rows_of(columns)), positive(in_rows(told, columns)))


def positive(rows):
    """A column of whole numbers has no zero with a sign, in tables that look for whole numbers."""
    return [[number + 0.0 for number in row] for row in rows]


def read_csv_pandas(what, data, headers, columns):
    frame = pandas.read_csv(io.BytesIO(data), comment="#", float_precision="round_trip")
    same(what, positive(rows_of(columns)), positive(frame.to_numpy(float).tolist()))


RSCRIPT = ["Rscript", "--vanilla"]
TABLE = """
word <- commandArgs(TRUE)
table <- read.csv(word[1], comment.char = "#", colClasses = "numeric")
writeBin(as.vector(t(as.matrix(table))), word[2], endian = "little")
"""
ARRAYS = """
word <- commandArgs(TRUE)
out <- file(word[2], "wb")
for (name in strsplit(word[3], ",")[[1]])
  writeBin(as.double(rhdf5::h5read(word[1], name)), out, endian = "little")
close(out)
"""


def read_csv_r(what, data, headers, columns):
    """R reads decimals in long doubles, and rounds twice: the last bit may be another."""
    wanted, rows = rows_of(columns), in_rows(program(what, "csv", data, RSCRIPT, TABLE)[0], columns)
    near = len(wanted) == len(rows) and all(abs(a - b) <= 4e-16 * abs(a) for one, other in zip(wanted, rows) for a, b in zip(one, other))
    check(what, near, f"{len(rows)} rows of {len(wanted)}")


def read_hdf5_r(what, data, headers, columns):
    """The last axis comes first there, so that the numbers have their order in the file."""
    same_in_turn(what, columns, program(what, "h5", data, RSCRIPT, ARRAYS, ",".join(columns))[0])


def works(command):
    """Whether a program is there with what it needs."""
    return shutil.which(command[0]) and not subprocess.run(command, capture_output=True, timeout=120).returncode


def read_mat_scipy(what, data, headers, columns):
    arrays, rows, words = {}, len(next(iter(columns.values()))), []
    for name, value in scipy.io.loadmat(io.BytesIO(data)).items():
        if name == "stats":
            check(f"{what}: statistics", not has_method(what) or value["method"][0, 0][0] == "taylor" and
                  re.fullmatch("[0-9a-f]{16}", value["engine"][0, 0][0]), value)
        elif name == "warnings":
            words = [line.rstrip() for line in value]
        elif value.__class__.__name__ == "ndarray" and value.dtype.names:
            arrays |= {f"{name}_{part}": value[part][0, 0] for part in value.dtype.names}
        elif not name.startswith("__"):
            arrays[name] = value
    warned(what, words, columns)
    compare_arrays(what, {name: value.reshape(rows, -1).tolist() for name, value in arrays.items()}, columns)


TELL = """
1;
function tell(out, name, value)
  if isstruct(value)
    for [part, key] = value
      tell(out, [name '_' key], part);
    end
  elseif ischar(value)
    for i = 1:rows(value)
      printf('# %s\\n', strtrim(value(i, :)));
    end
  else
    printf('%s %d %d\\n', name, rows(value), columns(value));
    fwrite(out, real(value.'), 'double');
    fwrite(out, imag(value.'), 'double');
  end
end
s = load(argv(){1});
out = fopen(argv(){2}, 'w');
for [value, name] = rmfield(s, intersect(fieldnames(s), {'stats'}))
  tell(out, name, value);
end
fclose(out);
"""


def read_mat_octave(what, data, headers, columns):
    numbers, told = program(what, "mat", data, [OCTAVE, "--norc", "--quiet"], TELL)
    arrays, at, lines = {}, 0, told.splitlines()
    warned(what, [line.removeprefix("# ") for line in lines if line.startswith("# ")], columns)
    for line in lines:
        if line.startswith("# "):
            continue
        name, rows, width = (int(word) if word.isdigit() else word for word in line.split())
        count = rows * width
        pairs = [complex(a, b) for a, b in zip(numbers[at:at + count], numbers[at + count:at + 2 * count])]
        at += 2 * count
        arrays[name] = [pairs[i * width:(i + 1) * width] for i in range(rows)]
    arrays = {name: rows if f"{name}_re" in columns else [[z.real for z in row] for row in rows] for name, rows in arrays.items()}
    compare_arrays(what, arrays, columns)


DUCK = works(["node", "--input-type=module", "-e", f"await import({json.dumps(str(DUCKDB.resolve()))})"])
READERS = [
    ("CSV", "text/csv", read_csv, True, ""),
    ("CSV in pandas", "text/csv", read_csv_pandas, pandas, "python3-pandas is not installed"),
    ("CSV in R", "text/csv", read_csv_r, works([*RSCRIPT, "-e", "0"]), "r-base-core is not installed"),
    ("CSV in DuckDB", "text/csv", read_csv_duckdb, DUCK, "npm has not brought DuckDB for this machine"),
    ("NDJSON", "application/x-ndjson", read_ndjson, True, ""),
    ("octet-stream in NumPy", "application/octet-stream", read_octets, numpy, "python3-numpy is not installed"),
    ("NPZ in NumPy", "application/x-npz", read_npz, numpy, "python3-numpy is not installed"),
    ("HDF5 in h5py", "application/x-hdf5", read_hdf5, h5py, "python3-h5py is not installed"),
    ("HDF5 in h5dump", "application/x-hdf5", read_h5dump, shutil.which("h5dump"), "hdf5-tools are not installed"),
    ("HDF5 in Octave", "application/x-hdf5", read_hdf5_octave, OCTAVE, "octave is not installed"),
    ("HDF5 in R", "application/x-hdf5", read_hdf5_r, works([*RSCRIPT, "-e", "library(rhdf5)"]), "r-bioc-rhdf5 is not installed"),
    ("Parquet in DuckDB", "application/vnd.apache.parquet", read_parquet_duckdb, DUCK, "npm has not brought DuckDB for this machine"),
    ("Parquet in pandas", "application/vnd.apache.parquet", read_parquet, pandas and tables, "pandas with pyarrow or fastparquet is not installed"),
    ("Parquet in JavaScript", "application/vnd.apache.parquet", read_parquet_node, HYPARQUET.exists(), "npm has not brought hyparquet"),
    ("MAT in SciPy", "application/x-matlab-data", read_mat_scipy, scipy, "python3-scipy is not installed"),
    ("MAT in Octave", "application/x-matlab-data", read_mat_octave, OCTAVE, "octave is not installed"),
]


def main():
    with daemon(sys.argv[1], "--cache-bytes", "0") as server:
        for title, (path, body) in REQUESTS.items():
            status, _, data = server.ask(body, path=path)
            check(f"{title}: JSON", status == 200, f"{status} {data[:300]}")
            columns = columns_of(json.loads(data))
            check(f"{title}: warnings", bool(columns.warnings) or "past its horizon" not in title, "there are none")
            for name, media_type, read, there, _ in READERS:
                if there:
                    status, headers, data = server.ask(body, media_type, path=path)
                    check(f"{title}, {name}", status == 200, f"{status} {data[:300]}")
                    if status == 200:
                        read(f"{title}, {name}", data, headers, columns)
        # rounded numbers are the same texts everywhere
        path, body = REQUESTS["its default output"]
        rounded = body[:-1] + ',"digits":6}'
        columns = columns_of(json.loads(server.ask(rounded, path=path)[2]))
        for name, media_type, read, _, _ in READERS[:2]:
            _, headers, data = server.ask(rounded, media_type, path=path)
            read(f"six digits, {name}", data, headers, columns)
    for name, _, _, there, why in READERS:
        if not there:
            skip(name, why)
    sys.exit(summary())


main()
