"""The table of nickname.c as C: to what each character folds that does not fold to itself.

usage: nickname_table.py nickname_alike.txt
Decomposition, case and categories are those of Python's Unicode; nickname_alike.txt has the characters of other scripts that look alike.
Leaves to others: folding a name (nickname.c). Invariant: the same Python and the same file give the same bytes.
"""
import sys
import unicodedata

DIGITS = str.maketrans("ilo", "110")
# without a picture, and no control or format characters (Default_Ignorable_Code_Point, and the blank of Braille)
UNSEEN = {0x34F, 0x115F, 0x1160, 0x17B4, 0x17B5, 0x2800, 0x3164, 0xFFA0, *range(0x180B, 0x1810), *range(0x2060, 0x2070), *range(0xFE00, 0xFE10),
          *range(0xFFF0, 0xFFF9), *range(0xE0000, 0xE1000)}


def seen(letter):
    return unicodedata.category(letter) not in ("Cc", "Cf", "Zs", "Zl", "Zp") and ord(letter) not in UNSEEN


def main(path):
    with open(path, encoding="utf-8") as file:
        words = file.read().partition("\n\n")[2].split()
    alike = {letter: fold for fold, letters in zip(words[::2], words[1::2]) for letter in letters}
    rows, marks, text, places = [], [], b"", {}
    for code in range(1, sys.maxunicode + 1):
        letter = chr(code)
        if 0xD800 <= code < 0xE000:
            continue
        if unicodedata.combining(letter):
            if not marks or marks[-1][1] != code - 1:
                marks.append([code, code])
            marks[-1][1] = code
        kept = unicodedata.normalize("NFD", "".join(filter(seen, unicodedata.normalize("NFKC", letter))))
        fold = "".join(alike.get(one) or unicodedata.normalize("NFD", one.casefold()).translate(DIGITS) for one in kept).encode()
        if fold == letter.encode():
            continue
        if fold not in places:
            places[fold] = len(text)
            text += fold + b"\0"
        rows.append((code, places[fold]))
    print('#include "server/classes/nickname_table.h"\n\nconst struct srv_nickname_row srv_nickname_rows[] = {')
    print("\n".join(f"    {{{code}, {place}}}," for code, place in rows) + "\n};\nconst unsigned srv_nickname_marks[][2] = {")
    print("\n".join(f"    {{{first}, {last}}}," for first, last in marks) + "\n};\nconst char srv_nickname_text[] = {")
    print("\n".join("    " + " ".join(f"'\\{byte:o}'," for byte in text[at:at + 16]) for at in range(0, len(text), 16)) + "\n};")
    print(f"const size_t srv_nickname_row_count = {len(rows)}, srv_nickname_mark_count = {len(marks)};")


main(sys.argv[1])
