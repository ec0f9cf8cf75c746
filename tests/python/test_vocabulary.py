"""What the C++ sources promise their readers: short signatures, one name for each header."""

import re
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[2]
MOST_PARAMETERS = 6

FUNCTION = re.compile(r"OMMA_HD(?:_CALLED)?\s[^;{}=]*?\b([\w]+|operator\S+?)\s*\(")


def without_comments(text):
    return re.sub(r"//[^\n]*", "", text)


def parameters_of(text, begin):
    """What lies between the brackets that open before ``begin``, cut at its commas."""
    depth, parts, last = 0, [], begin
    for at in range(begin, len(text)):
        if text[at] in "([{<":
            depth += 1
        elif text[at] in ")]}>" and text[at - 1] != "-":
            depth -= 1
            if depth < 0:
                parts.append(text[last:at])
                break
        elif text[at] == "," and depth == 0:
            parts.append(text[last:at])
            last = at + 1
    return [part for part in parts if part.strip()]


def functions(path):
    """Names and numbers of parameters of the functions that a header has."""
    text = without_comments(path.read_text())
    for found in FUNCTION.finditer(text):
        yield found[1], len(parameters_of(text, found.end()))


def headers():
    return sorted([*(ROOT / "src").rglob("*.h"), *(ROOT / "include").rglob("*.h")])


def test_functions_of_the_physics_have_few_parameters():
    counted = [
        (path.name, name, count)
        for path in sorted((ROOT / "src" / "physics").glob("*.h"))
        for name, count in functions(path)
    ]
    assert len(counted) > 300
    assert ("lanes.h", "gather", 2) in counted
    assert [one for one in counted if one[2] > MOST_PARAMETERS] == []


def test_headers_have_names_of_their_own():
    names = Counter(path.name for path in headers())
    assert [name for name, count in names.items() if count > 1] == []


def test_block_says_what_a_search_has():
    physics = sorted((ROOT / "src" / "physics").glob("*.h"))
    called = {
        name
        for path in physics
        for name in re.findall(r"\bsearch\.(\w+)\(", without_comments(path.read_text()))
    }
    said = set(re.findall(r"^//   (\w+)\(", (ROOT / "src/physics/block.h").read_text(), re.M))
    assert called == said == {"closest", "occluded", "placed"}
