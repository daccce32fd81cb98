"""Edits of tables, JSON lines and TOML: cells, rows, columns, keys and values that no one expected."""

from __future__ import annotations

import csv
import io
import json
import tomllib
import zlib
from typing import Any

import numpy as np

from ppinfer.testing.mutations import Effect

CELLS = (
    "", " ", "nan", "NaN", "inf", "-inf", "Infinity", "1e308", "-1e308", "1e999", "1e-400", "-0", "abc", "=cmd()",
    "@SUM(1)", "<script>alert(1)</script>", "0x10", "1,5", "1_000", "١٢", "true", "None", "9" * 400, "x" * 10_000,
    "../../etc/passwd", "2020-01-01", "%s{}", "\x1b[31m", "💥", "'", '"', "\t", "\n", "-1", "0", "1", "1.5", "9e15",
)  # fmt: skip
"""What a cell may hold that nobody thought of."""

_VALUES: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 2**31, 2**63, -(2**63), 10**40, 1.5, 1e308, float("nan"), float("inf"), "", "x",
    "inf", "../../etc/passwd", "<f8", "x" * 10_000, [], [[]], [None], {}, {"a": {}}, [0, 1, 2], ["a", "b"],
)  # fmt: skip
_MARK = '{"crc32": "'


def mutated_table(content: bytes, rng: np.random.Generator) -> tuple[str, Effect, bytes]:
    r"""Edit a table with a header: cells, rows and columns; or write the same one otherwise.

    Examples
    --------
    >>> mutated_table(b"t,x\n0,1\n1,2\n", np.random.default_rng(0))
    ('2 cells changed', 'edit', b't,x\n ,1\n,2\n')
    """
    text = content.decode()
    delimiter = ";" if text.split("\n", 1)[0].count(";") > text.split("\n", 1)[0].count(",") else ","
    rows = list(csv.reader(io.StringIO(text), delimiter=delimiter))
    width = len(rows[0])
    way = rng.integers(6)
    if way == 0:
        order = rng.permutation(width)
        columns = [[row[index] for index in order] if len(row) == width else row for row in rows]
        return "columns in another order", "same", _written(columns, delimiter)
    if way == 1:
        quoted = _written(rows, delimiter, quoting=csv.QUOTE_ALL, end=str(rng.choice(["\n", "\r\n"])))
        return "every cell quoted", "same", quoted
    if way == 2:
        column = int(rng.integers(width))
        kind = rng.integers(4)
        if kind == 0:
            rows = [[*row[:column], *row[column + 1 :]] for row in rows]
            return f"column {column} lost", "edit", _written(rows, delimiter)
        if kind == 1:
            rows[0][column] = f"{rows[0][column]}_"
            return f"column {column} renamed", "edit", _written(rows, delimiter)
        if kind == 2:
            rows[0][column] = rows[0][0]
            return f"column {column} named as the first", "edit", _written(rows, delimiter)
        rows = [[*row, row[column] if column < len(row) else ""] for row in rows]
        return f"column {column} doubled", "edit", _written(rows, delimiter)
    told, body = _edited_rows(rows[1:], rng)
    return told, "edit", _written([rows[0], *body], delimiter)


def mutated_columns(content: bytes, rng: np.random.Generator) -> tuple[str, Effect, bytes]:
    r"""Edit a table of white space without a header, or a text of words.

    Examples
    --------
    >>> mutated_columns(b"0 1\n1 2\n", np.random.default_rng(1))
    ('2 rows longer', 'edit', b'0 1 1\n1 2 1\n')
    """
    rows = [line.split() for line in content.decode().splitlines()]
    told, rows = _edited_rows(rows, rng)
    return told, "edit", "".join(" ".join(row) + "\n" for row in rows).encode()


def _edited_rows(rows: list[list[str]], rng: np.random.Generator) -> tuple[str, list[list[str]]]:
    if not rows:
        return "a row of garbage", [["x"]]
    rows = [list(row) for row in rows]
    count = min(len(rows), 2 ** int(rng.integers(0, 6)))
    chosen = sorted(rng.choice(len(rows), count, replace=False).tolist())
    way = rng.integers(8)
    if way <= 2:
        for index in chosen:
            if rows[index]:
                rows[index][rng.integers(len(rows[index]))] = str(rng.choice(CELLS))
        return f"{count} cells changed", rows
    if way == 3:
        # a whole column: what is wrong in every row must be told as briefly as what is wrong in one
        column, cell = int(rng.integers(max(1, len(rows[0])))), str(rng.choice(CELLS))
        return f"column {column} overwritten", [[*row[:column], cell, *row[column + 1 :]] for row in rows]
    if way == 4:
        moved = [rows[index] for index in rng.permutation(len(rows))]
        return f"{len(rows) - 1} rows shuffled", moved
    if way == 5:
        return f"{count} rows doubled", [
            row for index, row in enumerate(rows) for _ in range(1 + (index in chosen))
        ]
    if way == 6:
        lost = set(chosen)
        return f"{count} rows lost", [row for index, row in enumerate(rows) if index not in lost]
    longer = rng.random() < 0.5
    for index in chosen:
        rows[index] = [*rows[index], "1"] if longer else rows[index][:-1]
    return f"{count} rows {'longer' if longer else 'shorter'}", rows


def _written(
    rows: list[list[str]], delimiter: str, *, quoting: Any = csv.QUOTE_MINIMAL, end: str = "\n"
) -> bytes:
    out = io.StringIO()
    csv.writer(out, delimiter=delimiter, quoting=quoting, lineterminator=end).writerows(rows)
    return out.getvalue().encode("utf-8", "surrogatepass")


def mutated_text(content: bytes, rng: np.random.Generator) -> tuple[str, Effect, bytes]:
    r"""Save a text in another encoding, or put marks, lines and control characters where none belong.

    Examples
    --------
    >>> mutated_text(b"t,x\n0,1\n", np.random.default_rng(0))
    ('line 1 doubled', 'damage', b't,x\n0,1\n0,1\n')
    """
    text = content.decode()
    lines = text.splitlines(keepends=True)
    line = int(rng.integers(max(1, len(lines))))
    way = rng.integers(6)
    if way == 0:
        return "saved as UTF-16", "damage", text.encode("utf-16")
    if way == 1:
        return (
            "a letter of Latin-1",
            "damage",
            content[: len(content) // 2] + b"\xe9" + content[len(content) // 2 :],
        )
    if way == 2:
        cell = str(rng.choice(CELLS))
        return (
            f"line {line} replaced",
            "damage",
            "".join([*lines[:line], f"{cell}\n", *lines[line + 1 :]]).encode(),
        )
    if way == 3:
        return f"line {line} doubled", "damage", "".join([*lines[: line + 1], *lines[line:]]).encode()
    if way == 4:
        return f"line {line} lost", "damage", "".join([*lines[:line], *lines[line + 1 :]]).encode()
    character = str(rng.choice(["\0", "\x1b", "\x85", "\u2028", "\ufeff", "\v", "\r"]))
    at = int(rng.integers(len(text) + 1))
    return f"{character!r} inserted", "damage", (text[:at] + character + text[at:]).encode()


def mutated_json(content: bytes, rng: np.random.Generator) -> tuple[str, Effect, bytes]:
    """Change, drop, rename or nest some value of a JSON document.

    Examples
    --------
    >>> mutated_json(b'{"shape": [3]}', np.random.default_rng(2))
    ('/shape/0 lost', 'damage', b'{"shape": []}')
    """
    told, value = changed_value(json.loads(content), rng)
    return told, "damage", json.dumps(value).encode()


def mutated_lines(content: bytes, rng: np.random.Generator) -> tuple[str, Effect, bytes]:
    r"""Edit JSON lines: a value with the line's checksum made anew, or whole lines lost, doubled or shuffled.

    Examples
    --------
    >>> mutated_lines(b'{"a": 1}\n{"a": 2}\n', np.random.default_rng(0))
    ('line 1: /a = 9223372036854775808', 'edit', b'{"a": 1}\n{"a": 9223372036854775808}\n')
    """
    lines = content.decode().splitlines()
    line = int(rng.integers(len(lines)))
    way = rng.integers(8)
    if way == 0:
        return f"line {line} doubled", "edit", _joined([*lines[: line + 1], *lines[line:]])
    if way == 1:
        return f"line {line} lost", "edit", _joined([*lines[:line], *lines[line + 1 :]])
    if way == 2:
        return "lines shuffled", "edit", _joined([lines[index] for index in rng.permutation(len(lines))])
    signed = lines[line].startswith(_MARK)
    start = len(_MARK)
    document = json.loads("{" + lines[line][start + 11 :] if signed else lines[line])
    told, value = changed_value(document, rng)
    body = json.dumps(value)
    if signed and isinstance(value, dict) and value:
        body = f'{_MARK}{zlib.crc32(body.encode()):08x}", {body[1:]}'
    lines[line] = body
    return f"line {line}: {told}", "edit", _joined(lines)


def _joined(lines: list[str]) -> bytes:
    return "".join(f"{line}\n" for line in lines).encode()


def mutated_toml(content: bytes, rng: np.random.Generator) -> tuple[str, Effect, bytes]:
    r"""Change, drop, rename or nest some value of a TOML document, or write the same one otherwise.

    Examples
    --------
    >>> mutated_toml(b'time = "t"', np.random.default_rng(2))
    ('/time lost', 'edit', b'')
    """
    import tomli_w

    document = tomllib.loads(content.decode())
    if rng.random() < 0.1:
        return "written anew", "same", tomli_w.dumps(document).encode()
    told, value = changed_value(document, rng)
    try:
        return told, "edit", tomli_w.dumps(value).encode()
    except (TypeError, AttributeError):
        # there is no null in TOML
        return "null", "damage", content + b"\nnothing = null\n"


def changed_value(document: Any, rng: np.random.Generator) -> tuple[str, Any]:
    """Return a document of dicts and lists with one value changed, and what was done.

    Examples
    --------
    >>> changed_value({"a": [1, 2]}, np.random.default_rng(1))
    ('/a/1 = None', {'a': [1, None]})
    """
    document = json.loads(json.dumps(document, default=str))
    place: Any = document
    parent: Any = None
    key: Any = None
    path = ""
    # half of the time deeper, so that what is near the top is changed as often as what is many
    while isinstance(place, dict | list) and place and (parent is None or rng.random() < 0.7):
        keys: list[Any] = list(place) if isinstance(place, dict) else list(range(len(place)))
        parent, key = place, keys[rng.integers(len(keys))]
        place = place[key]
        path += f"/{key}"
    if parent is None:
        return "replaced", _VALUES[rng.integers(len(_VALUES))]
    way = rng.integers(6)
    if way == 0:
        del parent[key]
        return f"{path} lost", document
    if way == 1 and isinstance(parent, dict):
        parent[f"{key}_"] = parent.pop(key)
        return f"{path} renamed", document
    if way == 2:
        parent[key] = [place, place]
        return f"{path} doubled", document
    parent[key] = _VALUES[rng.integers(len(_VALUES))]
    shown = repr(parent[key])
    return f"{path} = {shown[:40]}", document
