"""Adds up the tests of all languages and the other checks for scripts/test.

Usage: summarise.py FOLDER "passed NAME" "failed NAME" ...

FOLDER holds the JUnit reports cpp.xml and python.xml. A check that ran no tests, or that failed
although none of its tests did, counts as one test. Of C++ tests that failed, it prints the end of
what they printed; pytest does so itself.
"""

import sys
import xml.etree.ElementTree as ET
from pathlib import Path

REPORTS = {"C++ tests": "cpp.xml", "Python tests": "python.xml"}
SHOWN_LINES = 30


def count(report: Path) -> tuple[dict[str, int], list[str]]:
    """Tests passed, failed and skipped in a JUnit report, and the names of those that failed."""
    totals = {"passed": 0, "failed": 0, "skipped": 0}
    failed = []
    for case in ET.parse(report).getroot().iter("testcase"):
        if case.find("failure") is not None or case.find("error") is not None:
            totals["failed"] += 1
            place, name = case.get("classname", ""), case.get("name", "")
            failed.append(name if name.startswith(place) else f"{place} {name}")
        elif case.find("skipped") is not None or case.get("status") in ("notrun", "disabled"):
            totals["skipped"] += 1
        else:
            totals["passed"] += 1
    return totals, failed


def printed_by(report: Path, test: str) -> list[str]:
    """The last lines that a failed test of a JUnit report by CTest printed."""
    for case in ET.parse(report).getroot().iter("testcase"):
        if case.get("name") == test:
            return (case.findtext("system-out") or "").rstrip().splitlines()[-SHOWN_LINES:]
    return []


def main() -> int:
    folder, checks = Path(sys.argv[1]), sys.argv[2:]
    sums = {"passed": 0, "failed": 0, "skipped": 0}
    for check in checks:
        outcome, name = check.split(" ", 1)
        totals, failed = {"passed": 0, "failed": 0, "skipped": 0}, []
        report = folder / REPORTS.get(name, "none")
        if report.is_file():
            totals, failed = count(report)
        if totals["passed"] == 0 and not failed and name in REPORTS:
            outcome = "failed"  # no test ran where there must be some
        if outcome == "failed" and not failed:
            totals["failed"] += 1
            failed.append(name)
        elif not report.is_file():
            totals[outcome] += 1
        for key, value in totals.items():
            sums[key] += value
        numbers = ", ".join(f"{value} {key}" for key, value in totals.items() if value)
        print(f"  {name + ':':36} {numbers}")
        for test in failed:
            if test != name:
                print(f"    failed: {test}")
                for line in printed_by(report, test) if name == "C++ tests" else []:
                    print(f"      {line}")
    print(f"{sums['passed']} passed, {sums['failed']} failed, {sums['skipped']} skipped")
    return 1 if sums["failed"] else 0


if __name__ == "__main__":
    sys.exit(main())
