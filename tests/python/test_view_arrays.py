"""Every array of the views that the physics reads is in the table of src/backend/view_arrays.h, by
which views are copied to other memory."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
TABLE = ROOT / "src" / "backend" / "view_arrays.h"
# What is handed over for a render and for a bake, and what a search goes by: all else is reached
# from these.
ROOTS = ["FrameView", "BlockTask", "GatherTask", "SharedWeights", "WeighTask", "BvhView"]

STRUCT = re.compile(r"\bstruct\s+(?:alignas\([^)]*\)\s*)?(\w+)\s*(?::\s*(\w+)\s*)?\{")
MEMBER = re.compile(r"(?:const\s+)?(\w+(?:::\w+)*)(?:<[^>]*>)?\s*(.+)", re.S)
DECLARATOR = re.compile(r"((?:const|[*\s])*)(\w+)\s*(?:\[[^\]]*\]\s*)*")


def block_from(text, begin):
    """What lies between the bracket that ``begin`` is behind and the one that closes it."""
    depth = 1
    for at in range(begin, len(text)):
        depth += {"{": 1, "}": -1}.get(text[at], 0)
        if depth == 0:
            return text[begin:at]
    raise AssertionError("a bracket is not closed")


def members_of(body):
    """(name, type, whether it is a pointer) of the members of a struct."""
    # Bodies of functions and initialisers away, innermost brackets first.
    while re.search(r"\{[^{}]*\}", body):
        body = re.sub(r"\s*(?:=\s*)?\{[^{}]*\}", "", body)
    for statement in body.split(";"):
        statement = re.sub(r"=[^,]*", "", statement).strip()
        if not statement or re.match(r"(static|using|friend|enum|struct)\b", statement):
            continue
        found = MEMBER.fullmatch(statement)
        if "(" in statement or found is None:
            continue
        for part in found[2].split(","):
            declared = DECLARATOR.fullmatch(part.strip())
            if declared:
                yield declared[2], found[1], "*" in declared[1]


def structs():
    found = {}
    for folder in ("include", "src/physics"):
        for path in sorted((ROOT / folder).rglob("*.h")):
            text = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
            for one in STRUCT.finditer(text):
                members = list(members_of(block_from(text, one.end())))
                found[one[1]] = members + found.get(one[2], [])
    return found


def arrays_by_struct(known):
    """{struct: [(member, its type, whether it points)]} of members that point, or hold what points,
    of all that ROOTS lead to."""
    reached, waiting = {}, list(ROOTS)
    while waiting:
        name = waiting.pop()
        if name in reached:
            continue
        reached[name] = [
            (member, kind, pointed)
            for member, kind, pointed in known[name]
            if pointed or holds_pointers(known, kind)
        ]
        waiting += [kind for _, kind, _ in known[name] if kind in known]
    return {name: members for name, members in reached.items() if members}


def holds_pointers(known, name):
    return any(pointed or holds_pointers(known, kind) for _, kind, pointed in known.get(name, []))


def visited(table, struct):
    """(member, how it is visited) of the members that the table's function for a struct visits."""
    found = re.search(rf"\bvisit_arrays\({struct}& view,[^)]*\) \{{", table)
    if found is None:
        return set()
    body = block_from(table, found.end())
    # An array of arrays, component by component.
    body = re.sub(r"\bfor \([^:()]*: view\.(\w+)\) visit\(", r"visit(view.\1, ", body)
    return {(name, how) for how, name in re.findall(r"\b(visit[\w.]*)\(view\.(\w+)", body)}


def way(kind, pointed, arrays):
    """How a member is to be visited: one that holds arrays itself, and one that points to such."""
    if not pointed:
        return "visit_arrays"
    return "visit.views" if kind in arrays else "visit"


def missing(table, arrays):
    return [
        f"{struct}::{member}"
        for struct, members in sorted(arrays.items())
        for named in [visited(table, struct)]
        for member, kind, pointed in members
        if (member, way(kind, pointed, arrays)) not in named
    ]


def test_the_table_has_all_arrays_of_the_views():
    arrays = arrays_by_struct(structs())
    assert sum(pointed for members in arrays.values() for *_, pointed in members) > 100
    assert ("radiance", "float", True) in arrays["SkyView"]
    assert ("sky", "SkyView", False) in arrays["LightView"]
    table = TABLE.read_text(encoding="utf-8")
    assert missing(table, arrays) == []


def test_a_line_that_is_not_there_is_missed():
    arrays = arrays_by_struct(structs())
    lines = TABLE.read_text(encoding="utf-8").splitlines()
    tried = [i for i, line in enumerate(lines) if re.match(r"  (for .*)?visit", line)]
    assert len(tried) > 100
    for i in tried:
        assert len(missing("\n".join(lines[:i] + lines[i + 1 :]), arrays)) == 1, lines[i]
