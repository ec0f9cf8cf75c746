"""The arithmetic of the bench report, on curves whose answers are known."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from curves import crossing, least, pick, random_error
from report import cameras, motion, report
from report_cameras import front, ms_to, times_table
from report_light import (
    PARTS,
    aims_of_light,
    beside_paths,
    beside_peer,
    frames_that_pay,
    light,
    light_to_error,
    part_costs,
    to_error_table,
)
from report_speed import serial_fraction
from run import write_lines


def curve(method, scale, power):
    """Rows of an error that falls with a power of the rays, at 0.01 ms a ray."""
    return [
        {
            "scene": "a", "ommatidia": "7", "reference_rays": "65536", "method": method,
            "setting": str(n), "rays": str(n), "rms": str(scale * n**-power), "bias": "0",
            "ms_per_frame": str(0.01 * n),
        }
        for n in (1, 4, 16, 64, 100, 256)
    ]  # fmt: skip


ROWS = curve("random", 0.3, 0.5) + curve("footprints", 0.3, 1.0) + curve("target from 4", 0.1, 0.5)


def test_random_error_is_that_of_the_law():
    assert random_error(ROWS, 100) == pytest.approx(0.03)
    assert random_error(ROWS, 3200) == pytest.approx(0.3 / 3200**0.5)


def test_crossing_is_exact_on_power_laws():
    # 0.3 / n = 0.03 at 10 rays, between two points.
    found = crossing(pick(ROWS, method="footprints"), 0.03)
    assert found.rays == pytest.approx(10)
    assert found.ms == pytest.approx(0.1)
    # 0.1 / sqrt(n) = 0.03 at 100 / 9 rays, so the other method takes fewer.
    assert crossing(pick(ROWS, method="target from 4"), 0.03).rays == pytest.approx(100 / 9)
    assert least(ROWS, "", 0.03).method == "footprints"


def test_crossing_at_the_ends():
    assert crossing(pick(ROWS, method="footprints"), 0.5).rays == 1
    assert crossing(pick(ROWS, method="footprints"), 1e-4) is None
    assert least(ROWS, "no such method", 0.03) is None


def test_serial_share():
    assert serial_fraction(1.0, 0.5, 2) == pytest.approx(0)
    assert serial_fraction(1.0, 1.0, 2) == pytest.approx(1)
    assert serial_fraction(1.0, 0.1 + 0.9 / 16, 16) == pytest.approx(0.1)


def test_report_says_what_was_not_measured(tmp_path):
    write_lines(tmp_path / "machine.csv", ["what,found", "date,2026-01-01", 'memory,"1 GiB"'])
    rows = ROWS + curve("no footprints", 0.3, 0.75)
    lines = [",".join(ROWS[0]), *(",".join(row.values()) for row in rows)]
    write_lines(tmp_path / "error.csv", lines)
    text = "\n".join(report(tmp_path))
    assert "| a | 7 | 0.03000 | footprints | 10 | 10.00 | 0.1 | 10,000 | 10.0 |" in text
    assert "- ceiling was not measured" in text
    assert "CompoundRay's scenes and eyes, which are missing here" in text


def light_rows():
    """Ways of which each takes 10 ns more than the one before."""
    ways = list(dict.fromkeys(way for _, more, less in PARTS for way in (less, more)))
    taken = {way: 10.0 * (k + 1) for k, way in enumerate(ways)}
    times = {
        "unlit in bands": "1.25", "direct light": "4.0", "direct light, polarised": "1.05",
        "baked, sun exact": "2.5", "baked, sun map": "1.6",
        "paths, polarised": "1.08", "llvm_ad_rgb, up to 4": "2.5", "llvm_ad_spectral, up to 4": "3",
    }  # fmt: skip
    taken |= {"baked, sun exact": 25.0, "baked, sun map": 16.0}
    taken |= {"Omma, up to 4": 100.0, "llvm_ad_rgb, up to 4": 250.0}
    taken |= {"llvm_ad_spectral, up to 4": 300.0}
    return [
        {
            "scene": "a", "way": way, "bands": "16", "ns_per_ray": str(ns),
            "compared_with": "unlit", "times": times.get(way, ""),
        }
        for way, ns in taken.items()
    ]  # fmt: skip


def test_parts_of_light_are_differences():
    rows = light_rows()
    taken = {row["way"]: float(row["ns_per_ray"]) for row in rows}
    for (_, cost), (_, more, less) in zip(part_costs(rows), PARTS):
        assert cost == taken[more] - taken[less]


def test_light_is_compared_with_the_quicker_peer_and_the_aims():
    rows = light_rows()
    assert beside_peer(rows) == [("up to 4", 100.0, "llvm_ad_rgb", 250.0, 2.5)]
    reached = [cells[-1] for cells in aims_of_light(rows)]
    assert reached == ["0.80", "0.25", "5.00 to 8.00 %"]
    assert "| a | up to 4 | 10.00 | 4.00 | llvm_ad_rgb | 2.50 |" in light(rows)


def rows_to_error(scene, **ms):
    """Rows of light_to_error.py, by the milliseconds of each way; None where not reached."""
    return [
        {
            "scene": scene, "way": way, "ommatidia": "7", "rays": "64", "ms_a_frame": "1",
            "bake_cpu_s": "10" if way == "Omma, baked" else "0", "noise_percent": "5",
            "fixed_percent": "1", "median_percent": "1", "percentile_95_percent": "9",
            "ms_to_5_percent": "" if of_way is None else str(of_way),
            "ms_to_5_percent_each": "" if way == "Omma, baked" else str(4 * (of_way or 0)),
        }
        for way, of_way in ms.items()
    ]  # fmt: skip


def test_a_bake_is_spread_over_frames():
    ways = {
        "Omma, paths": 50.0,
        "Omma, baked": 10.0,
        "Omma, paths to an error": 20.0,
        "llvm_ad_rgb": 150.0,
    }
    rows = rows_to_error("a", **ways)
    rows += rows_to_error("b", **{"Omma, paths": 50.0, "Omma, baked": None})
    rows += rows_to_error("c", **{"Omma, paths": 50.0, "Omma, baked": 60.0})
    assert frames_that_pay(rows) == [("a", 250.0), ("b", None), ("c", None)]
    assert beside_paths(rows, "ms_to_5_percent", "Omma, paths") == [("a", "llvm_ad_rgb", 3.0)]
    each = beside_paths(rows, "ms_to_5_percent_each", "Omma, paths to an error")
    assert each == [("a", "llvm_ad_rgb", 7.5)]
    baked = to_error_table(rows)[1]
    assert baked[-4:] == ["10,010.0", "110.0", "11.0", ""]
    text = "\n".join(light_to_error(rows))
    assert "on baking pays: a: 250; b: never; c: never." in text
    text = text.replace("\n", " ")
    assert "to the same rms: a, llvm_ad_rgb: 3.0;" in text
    assert "as those to an error: a, llvm_ad_rgb: 7.5; the same, to the error of each" in text


def camera_rows(way, points):
    return [
        {
            "lighting": "unlit", "eye": "fly", "ommatidia": "7", "way": way, "setting": "a",
            "rays_per_ommatidium": "4", "setup_s": "0.1", "ms_per_frame": str(ms), "mean": "1",
            "error_percent": str(error), "noise_percent": "1", "bias_percent": "1",
            "place_percent": "0",
        }
        for ms, error in points
    ]  # fmt: skip


def test_times_to_an_error_are_those_of_the_best_settings():
    # From 40 % at 1 ms to 10 % at 4 ms, with a worse setting between.
    rows = camera_rows("Omma, own rays", [(4, 10), (1, 40), (3, 60)])
    assert front(rows) == [(1, 40), (4, 10)]
    assert ms_to(rows, 20) == pytest.approx(2)
    assert ms_to(rows, 50) == 1
    assert ms_to(rows, 5) is None


def test_the_section_of_cameras_leaves_out_what_is_missing():
    rows = camera_rows("Omma, own rays", [(1, 60), (4, 15)]) + camera_rows("truth", [])
    assert times_table(rows) == [
        ["unlit", "fly", "Omma, own rays", "2", "not reached", "not reached", "15"]
    ]
    assert "| unlit | fly | Omma, own rays | a | 4 | 0.1 | 4 | 15 | 1 | 1 | 0 |" in cameras(rows)


def test_the_section_of_motion():
    rows = [
        {"scene": "plain", "what": what, "setting": setting, "value": value}
        for what, setting, value in (
            ("frames per second", "still", "800"),
            ("of the still world", "still", "1.000"),
            ("loop µs", "50 %", "700"),
            ("loop histogram µs", "100.0", "3"),
        )
    ]
    rows.append({"scene": "tube", "what": "skin ms", "setting": "both", "value": "7.5"})
    section = motion(rows)
    assert "| both | 7.5 |" in section
    assert "| plain | still | 800 | 1.000 |" in section
    assert "| 50 % | 700 |" in section
