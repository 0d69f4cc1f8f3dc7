"""Sets of motions for machine learning: splits whose members never overlap, in shards, with a card.

    from pendulumd import Pendulum
    from pendulumd.dataset import dataset
    dataset(Pendulum(length=[1, 1], mass=[1, 1], parent=[0, 1]), "double", {"train": 8000, "test": 2000}, ...)

Leaves to others: what is drawn and computed (the server's /docs), jobs and downloads (Client). Invariant: a member of a set is a function
of seed, number and request alone, and every number is in one split; a shard that is there is whole, and of this request.
"""
from __future__ import annotations

import contextlib
import datetime
import hashlib
import json
import os
import platform
import re
import urllib.parse
import urllib.request
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Optional, Union

import numpy as np

from .client import Job, Problem, body_of

try:
    import fcntl
except ImportError:  # of Windows
    fcntl = None  # type: ignore[assignment]

__all__ = ["dataset", "manifest", "parts", "read_parquet"]
CARD, REQUEST, AHEAD = "croissant.json", "request.json", 4
WANTED = ("name", "description", "license", "creator", "url")  # what Croissant asks for and nobody but the author knows
TERMS = ("citeAs column dataType extract field fileProperty fileObject fileSet includes isLiveDataset key recordSet references regex source "
         "transform").split()
CONTEXT = {"@language": "en", "@vocab": "https://schema.org/", "sc": "https://schema.org/", "cr": "http://mlcommons.org/croissant/",
           "dct": "http://purl.org/dc/terms/", "conformsTo": "dct:conformsTo", "data": {"@id": "cr:data", "@type": "@json"},
           **{term: f"cr:{term}" for term in TERMS}, "dataType": {"@id": "cr:dataType", "@type": "@vocab"}}


def _shards(splits: Mapping[str, int], size: int, ending: str) -> Iterator[tuple[str, int, int]]:
    """Returns (name, first member, members) of each shard; the splits follow each other in one sequence of random members."""
    first = 0
    for split, count in splits.items():
        if not re.fullmatch(r"[A-Za-z0-9_]+", split) or count < 1:
            raise ValueError(f"a split is a word with a number of members above 0: {split!r}: {count!r}")
        pieces = -(-count // size)
        for piece in range(pieces):
            members = min(size, count - piece * size)
            yield f"{split}-{piece:05}-of-{pieces:05}{ending}", first, members
            first += members


def _digest(path: str) -> str:
    sha = hashlib.sha256()
    with open(path, "rb") as source:
        while piece := source.read(1 << 20):
            sha.update(piece)
    return sha.hexdigest()


def _keep(folder: str, text: bytes, names: Iterable[str]) -> None:
    """Writes the set's request beside it, or checks that it is the same; refuses a folder that has files but no request."""
    path = os.path.join(folder, REQUEST)
    if not os.path.exists(path):
        for name in names:
            if os.path.exists(os.path.join(folder, name)):
                raise ValueError(f"{folder} has {name} but no {REQUEST} that identifies its data set: use another folder, or remove it")
    else:
        with open(path, "rb") as source:
            if source.read() != text:
                raise ValueError(f"{folder} has the data set of another request: use another folder, or remove {path} and its shards")
    with open(path + ".part", "wb") as sink:
        sink.write(text)
    os.replace(path + ".part", path)


@contextlib.contextmanager
def _alone(folder: str) -> Iterator[None]:
    """Locks the folder, so that no other process makes a set there, if the system supports locks."""
    os.makedirs(folder, exist_ok=True)
    place = os.open(folder, os.O_RDONLY) if fcntl else -1
    try:
        try:
            if fcntl:
                fcntl.flock(place, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise ValueError(f"another process is writing the data set in {folder}") from None
        except OSError:
            pass  # this file system has no locks
        yield
    finally:
        if fcntl:
            os.close(place)


def _key(folder: str, body: Mapping[str, Any]) -> str:
    """Returns the key of a shard's job, by which a later run in this folder finds it; the job is removed with the finished shard."""
    return hashlib.sha256(f"{platform.node()}\0{os.path.abspath(folder)}\0".encode() + body_of(body)).hexdigest()[:48]


def _columns(job: Any) -> list[str]:
    """Returns the names of the columns, from the first line of the CSV."""
    headers = {"Accept": "text/csv", "Range": "bytes=0-65535"}
    connection, response = job.client._open("GET", f"/v1/jobs/{job.id}/results", None, headers)
    try:
        return str(response.read(65536).split(b"\n")[0].decode()).strip().split(",")
    finally:
        connection.close()


def _fetch(client: Any, folder: str, wanted: Sequence[tuple[str, Mapping[str, Any]]], progress: Any) -> Optional[list[str]]:
    """Computes and saves the missing shards, some jobs ahead; returns the names of their columns, None if no shard was missing."""
    waiting: list[tuple[str, Any]] = []
    columns: Optional[list[str]] = None
    for at in range(len(wanted) + AHEAD):
        if at < len(wanted):
            name, body = wanted[at]
            waiting.append((name, client.submit("ensembles", body, key=_key(folder, body), title=f"{folder}/{name}"[:100])))
        if waiting and (at >= AHEAD - 1 or at >= len(wanted)):
            name, job = waiting.pop(0)
            job.wait(progress)
            columns = columns or _columns(job)
            job.save(os.path.join(folder, name))
            try:
                job.cancel()  # what is on the disk here need not be kept there
            except Problem:
                pass
    return columns


def _field(path: str, source: Mapping[str, Any]) -> dict[str, Any]:
    return {"@type": "cr:Field", "@id": path, "name": path, "dataType": "sc:Float", "source": {"fileSet": {"@id": "shards"}, "extract": source}}


def _records(columns: Sequence[str], splits: Iterable[str]) -> list[dict[str, Any]]:
    """Describes the splits, and the members with a column for their split, with which the names of files begin."""
    split: dict[str, Any] = _field("members/split", {"fileProperty": "filename"}) | {"dataType": "sc:Text", "references": {"field": {"@id": "splits/name"}}}
    split["source"]["transform"] = {"regex": "^([A-Za-z0-9_]+)-[0-9]+-of-"}
    name = {"@type": "cr:Field", "@id": "splits/name", "name": "splits/name", "dataType": "sc:Text"}
    return [{"@type": "cr:RecordSet", "@id": "splits", "name": "splits", "dataType": "cr:Split", "key": {"@id": "splits/name"}, "field": [name],
             "data": [{"splits/name": one} for one in splits]},
            {"@type": "cr:RecordSet", "@id": "members", "name": "members",
             "field": [split, *(_field(f"members/{urllib.parse.quote(column)}", {"column": column}) for column in columns)]}]


def _card(folder: str, names: Sequence[str], columns: Sequence[str], splits: Iterable[str], card: Mapping[str, Any], kind: str) -> dict[str, Any]:
    """Describes the set by Croissant 1.0: its files with digests and sizes, its columns, its splits."""
    files = [{"@type": "cr:FileObject", "@id": name, "name": name, "contentUrl": name, "sha256": _digest(os.path.join(folder, name)),
              "contentSize": f"{os.path.getsize(os.path.join(folder, name))} B", "encodingFormat": "application/json" if name == REQUEST else kind}
             for name in [REQUEST, *names]]
    every = {"@type": "cr:FileSet", "@id": "shards", "name": "shards", "encodingFormat": kind, "includes": f"*-of-*{os.path.splitext(names[0])[1]}"}
    made = {"@context": CONTEXT, "@type": "sc:Dataset", "conformsTo": "http://mlcommons.org/croissant/1.0", "version": "1.0.0",
            "datePublished": datetime.datetime.now(datetime.timezone.utc).date().isoformat(), "isLiveDataset": False, **card,
            "distribution": [*files, every], "recordSet": _records(columns, splits)}
    with open(os.path.join(folder, CARD + ".part"), "w", encoding="utf-8") as sink:
        json.dump(made, sink, indent=1, ensure_ascii=False, allow_nan=False)
    os.replace(os.path.join(folder, CARD + ".part"), os.path.join(folder, CARD))
    return made


def dataset(pendulum: Any, folder: Any, splits: Mapping[str, int], *, draw: Any, card: Mapping[str, Any], seed: int = 0, shard: int = 10000, form: str = ".parquet",
            progress: Any = None, **fields: Any) -> dict[str, Any]:
    """Makes a set in `folder`, or continues one begun there; returns its card, also written there as croissant.json.

    splits  members of each: {"train": 80000, "validation": 10000, "test": 10000}
    draw    what is drawn for each member, by `seed`; `fields` are those of /v1/ensembles: duration, observables, output, ...
    shard   members of a file at most, each file a job: another size makes the same members
    form    .parquet or .csv
    card    name, description, license, creator and url of the set; more words of schema.org as you like
    """
    lacks = [word for word in WANTED if not card.get(word)]
    if lacks or form not in (".parquet", ".csv") or shard < 1:
        raise ValueError(f"the card lacks {', '.join(lacks)}" if lacks else f"a shard has members and is .parquet or .csv: {shard!r}, {form!r}")
    shards = list(_shards(splits, shard, form))
    request = pendulum.request(random={"count": sum(splits.values()), "seed": seed, "draw": draw}, **fields)
    with _alone(folder):
        _keep(folder, body_of({"request": request, "splits": splits, "shard": shard, "form": form}), [name for name, _, _ in shards])
        bodies = [(name, request | {"random": {"count": count, "seed": seed, "first": first, "draw": draw}}) for name, first, count in shards]
        columns = _fetch(pendulum.client, folder, [one for one in bodies if not os.path.exists(os.path.join(folder, one[0]))], progress)
        if columns is None:  # all shards are there: a job of one member tells their columns
            few = request | {"random": {"count": 1, "seed": seed, "draw": draw}}
            columns = _columns(pendulum.client.submit("ensembles", few, key=hashlib.sha256(body_of(few)).hexdigest()[:48]).wait())
        # Croissant's media type of Parquet
        return _card(folder, [name for name, _, _ in shards], columns, splits, card, "application/x-parquet" if form == ".parquet" else "text/csv")


# --- files of parts: of a job (?manifest=true), or of `pendulum --local --part K/N` ---

def _varint(data: bytes, at: int) -> tuple[int, int]:
    value = shift = 0
    while True:
        value |= (data[at] & 127) << shift
        shift, at = shift + 7, at + 1
        if data[at - 1] < 128:
            return value, at


def _thrift(data: bytes, at: int, kind: int = 12) -> tuple[Any, int]:
    """Reads a value of Thrift's compact protocol, which Parquet's metadata use; a struct becomes a dict by number."""
    if kind in (1, 2):
        return kind == 1, at
    if kind in (4, 5, 6):
        value, at = _varint(data, at)
        return value >> 1 ^ -(value & 1), at
    if kind == 8:
        size, at = _varint(data, at)
        return data[at:at + size], at + size
    if kind == 9:
        size, inner, at = data[at] >> 4, data[at] & 15, at + 1
        if size == 15:
            size, at = _varint(data, at)
        items = []
        for _ in range(size):
            item, at = _thrift(data, at, inner)
            items.append(item)
        return items, at
    if kind != 12:
        raise ValueError(f"not a Parquet file of pendulumd: type {kind}")
    fields: dict[int, Any] = {}
    number = 0
    while head := data[at]:
        at += 1
        if head >> 4:
            number += head >> 4
        else:
            value, at = _varint(data, at)
            number = value >> 1 ^ -(value & 1)
        fields[number], at = _thrift(data, at, head & 15)
    return fields, at + 1


def _footer(data: bytes) -> dict[int, Any]:
    if data[:4] != b"PAR1" or data[-4:] != b"PAR1":
        raise ValueError("not a Parquet file, or not the whole")
    return _thrift(data, len(data) - 8 - int.from_bytes(data[-8:-4], "little"))[0]  # type: ignore[no-any-return]


def read_parquet(data: bytes) -> dict[str, Any]:
    """Returns the columns of a Parquet file from pendulumd (plain numbers, not compressed) by name; needs only NumPy."""
    footer = _footer(data)
    names = [element[4].decode() for element in footer[2][1:]]
    columns: dict[str, list[Any]] = {name: [] for name in names}
    for group in footer[4]:
        for name, chunk in zip(names, group[1]):
            about = chunk[3]
            at = _thrift(data, about[9])[1]
            columns[name].append(np.frombuffer(data, "<f4" if about[1] == 4 else "<f8", about[5], at))
    return {name: np.concatenate(parts) if parts else np.empty(0) for name, parts in columns.items()}


def _bytes(href: str) -> bytes:
    with urllib.request.urlopen(href) if "://" in href else open(href, "rb") as source:
        return bytes(source.read())


def manifest(folder: Union[str, os.PathLike[str]]) -> dict[str, Any]:
    """Checks the files of parts in a folder, and writes and returns its manifest.json. A missing part, or a file that
    differs from its .sha256, is a ValueError."""
    folder = os.fspath(folder)
    files: list[dict[str, Any]] = []
    for name in sorted(os.listdir(folder)):
        if not (found := re.fullmatch(r"part-([0-9]+)(-[0-9a-f]+)?[.]parquet", name)):
            continue
        path = os.path.join(folder, name)
        data = _bytes(path)
        digest = hashlib.sha256(data).hexdigest()
        if os.path.exists(path + ".sha256"):
            with open(path + ".sha256", encoding="ascii") as written:
                if written.read().split()[0] != digest:
                    raise ValueError(f"{path} is not the file that was written: compute part {int(found[1])} again")
        if int(found[1]) != len(files) + 1:
            raise ValueError(f"{folder}: part {len(files) + 1} is missing")
        files.append({"part": int(found[1]), "href": name, "rows": _footer(data)[3], "bytes": len(data), "sha256": digest})
    if not files:
        raise ValueError(f"{folder} has no part-00001.parquet")
    made = {"files": files}
    with open(os.path.join(folder, "manifest.json"), "w", encoding="ascii") as out:
        json.dump(made, out, indent=1)
    return made


def parts(source: Union[str, os.PathLike[str], Job]) -> Iterator[dict[str, Any]]:
    """The columns of each part of a job, or of a manifest.json, in turn, each file checked against its digest; one file is in memory at a time.
    A ValueError names a file that is not the one that was written."""
    base = "" if isinstance(source, Job) else os.path.dirname(os.fspath(source))
    said = source.manifest() if isinstance(source, Job) else json.loads(_bytes(os.fspath(source)))
    for file in said["files"]:
        href = file["href"] if "://" in file["href"] else os.path.join(base, file["href"])
        data = _bytes(href)
        if hashlib.sha256(data).hexdigest() != file["sha256"]:
            raise ValueError(f"{href} is not the file that the manifest describes")
        yield read_parquet(data)


if __name__ == "__main__":
    import sys
    try:
        for folder_named in sys.argv[1:] or ["."]:
            print(f"{folder_named}: {len(manifest(folder_named)['files'])} parts")
    except ValueError as error:
        sys.exit(f"pendulumd.dataset: {error}")
