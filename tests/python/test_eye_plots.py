"""Figures of acceptance functions and posters: the right ommatidia, labels, units, clear errors."""

import numpy as np
import pytest
from conftest import svg_texts

import omma
from omma.eye.measures import measure_eye
from omma.eye.properties import PROPERTIES, eye_property
from omma.picture.acceptance_plots import choose, plot_acceptance
from omma.picture.poster import plot_poster, plot_species

pytest.importorskip("matplotlib")
pytestmark = pytest.mark.usefixtures("coarse_maps")


@pytest.fixture(scope="module")
def eye():
    zone = omma.eye.AcuteZone(0.0, 0.0, 0.7, 5.0)
    made = omma.eye.generate_eye(300, density=zone.density)
    kinds = [
        omma.Acceptance.gaussian(0.08),
        omma.Acceptance.gaussian(0.1, 0.05, np.radians(30)),
        omma.Acceptance.airy(20e-6, 500),
    ]
    return made.replace(acceptance=[kinds[i % 3] for i in range(300)])


def test_default_choice_is_the_least_the_median_and_the_large_angle(eye):
    measures = measure_eye(eye)
    least, middle, large = choose(eye, measures, None)
    angle = measures.interommatidial_rad
    assert angle[least] == angle.min()
    assert angle[middle] == pytest.approx(np.median(angle), rel=0.02)
    assert angle[large] == pytest.approx(np.percentile(angle, 95), rel=0.02)


def test_choice_by_index_and_direction(eye):
    measures = measure_eye(eye)
    ahead = int(eye.axis[:, 2].argmin())
    right_up = int((eye.axis @ np.array([np.sqrt(0.5), np.sqrt(0.5), 0])).argmax())
    assert choose(eye, measures, [7, (0.0, 0.0), (90.0, 45.0), 7]) == [7, ahead, right_up]


@pytest.mark.parametrize(
    ("ommatidia", "words"),
    [([], ["1 to 6", "0"]), (list(range(7)), ["6", "7"]), ([300], ["299", "300"]), ([-1], ["-1"])],
)
def test_wrong_choices_are_named(tmp_path, eye, ommatidia, words):
    with pytest.raises(omma.Error) as caught:
        plot_acceptance(tmp_path / "a.svg", eye, ommatidia)
    for word in words:
        assert word in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_acceptance_figure_says_what_it_shows(tmp_path, eye):
    plot_acceptance([tmp_path / "a.svg", tmp_path / "a.pdf"], eye, [0, 1, 2])
    said = svg_texts(tmp_path / "a.svg")
    sampling = np.radians(measure_eye(eye).sampling_per_rad[0])
    airy = np.degrees(1.0290 * 500e-9 / 20e-6)
    for words in (
        "angle from the axis θ (°)",
        "relative sensitivity S(θ)",
        "spatial frequency ν (cycles/°)",
        "modulation transfer M(ν)",
        "half maximum",
        "Gaussian of the same Δρ",
        f"0: gaussian, Δρ {np.degrees(0.08):.2f}°",
        f"1 widest, at 30°: gaussian, Δρ {np.degrees(0.1):.2f}°",
        f"1 narrowest, at 120°: gaussian, Δρ {np.degrees(0.05):.2f}°",
        f"2: airy, Δρ {airy:.2f}°",
        f"0: 1/(2Δφ) = {sampling:.3g} cycles/°",
        "S of ommatidium 1",
        "to its right (°)",
    ):
        assert words in said
    assert "S of ommatidium 0" not in said  # it is round


def test_equal_acceptances_are_one_curve(tmp_path, eye):
    plot_acceptance(tmp_path / "a.svg", eye, [0, 3, 6])
    said = svg_texts(tmp_path / "a.svg")
    assert f"0, 3, 6: gaussian, Δρ {np.degrees(0.08):.2f}°" in said


def test_the_same_eye_gives_the_same_bytes(tmp_path, eye):
    for name in ("a", "b"):
        plot_acceptance([tmp_path / f"{name}.svg", tmp_path / f"{name}.pdf"], eye)
    for ending in ("svg", "pdf"):
        assert (tmp_path / f"a.{ending}").read_bytes() == (tmp_path / f"b.{ending}").read_bytes()


@pytest.mark.parametrize("name", PROPERTIES)
def test_every_property_has_a_label_and_a_number_for_each(eye, name):
    found = eye_property(eye, measure_eye(eye), name)
    assert len(found.values) == len(eye)
    assert found.label


def test_eyes_and_text_columns_are_classes(eye):
    head = omma.eye.merge_eyes([eye, eye]).replace(columns={"kind": ["b", "a"] * 300})
    measures = measure_eye(head)
    found = eye_property(head, measures, "eye")
    assert found.classes == ("eye 0", "eye 1")
    assert (found.values == np.repeat([0, 1], 300)).all()
    found = eye_property(head, measures, "kind")
    assert found.classes == ("a", "b")
    assert found.values[:3].tolist() == [1, 0, 1]


@pytest.fixture(scope="module")
def head(eye):
    types = [
        omma.receptors.ReceptorType(
            "green", peak_wavelength_nm=544, absorption_per_m=6700, length_m=3e-4
        ),
        omma.receptors.ReceptorType("blue", peak_wavelength_nm=436),
        omma.receptors.ReceptorType(
            "blue-crossed", peak_wavelength_nm=436, microvillus_angle_rad=1.0
        ),
    ]
    return omma.eye.merge_eyes([eye, eye]).replace(
        facet_diameter_m=20e-6, receptor_types=types, receptors=[0, 1, 2]
    )


def test_poster_says_what_it_shows(tmp_path, head):
    plot_poster(
        tmp_path / "a.svg",
        head,
        title="A fly",
        facts=[("facets", "-20 µm", "measured, somebody 1999")],
        sources=["[somebody 1999] A paper"],
    )
    said = svg_texts(tmp_path / "a.svg")
    for words in ("A fly", "from ahead; colours as in the first map", "right eye, from its right",
                  "right eye, from ahead, right and above", "facets", "−20 µm",
                  "measured, somebody 1999", "interommatidial angle Δφ (°)",
                  "angle of touching facets, smaller (°)",
                  "angle of touching facets, larger (°)", "wavelength (nm)",
                  "green: 544 nm", "blue, blue-crossed: 436 nm", "ommatidia", "Facts it is made of",
                  "Sources: [somebody 1999] A paper", "optical sensitivity S",
                  "facet diameter D (µm): 20 throughout"):  # fmt: skip
        assert words in said, words
    assert not {"blue: 436 nm", "blue-crossed: 436 nm"} & set(said)  # they are one curve


def test_poster_of_an_eye_of_which_little_is_known(tmp_path):
    plot_poster(tmp_path / "a.png", omma.eye.generate_eye(60))
    assert (tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG"


def test_poster_of_an_eye_behind_one_lens(tmp_path):
    """Its facets are made up, which is said, and what only facets have is left out."""
    eye = omma.eye.generate_eye(60).replace(facet_diameter_m=500e-6)
    camera = eye.replace(position_m=np.tile([2e-4, 0, -1e-3], (60, 1)))
    told = []
    plot_poster(tmp_path / "a.svg", camera, progress=lambda *one: told.append(one))
    said = svg_texts(tmp_path / "a.svg")
    assert said.count("an eye's ommatidia are all at one point: drawn 1 mm out") == 3
    assert "acceptance Δρ" in said
    for words in ("touching facets", "D·Δφ"):
        assert not any(words in one for one in said)
    # Positions that are left out are 0: its facets may be those of an apposition eye.
    plot_poster(tmp_path / "b.svg", eye.replace(position_m=np.zeros((60, 3))))
    said = svg_texts(tmp_path / "b.svg")
    assert "eye parameter D·Δφ" in said
    assert "touching facets, mean" not in said
    shares = [share for stage, share in told if stage == "drawing"]
    assert len(shares) > 5
    assert shares == sorted(set(shares))
    # Of which nobody knows how far it is.
    assert told[-1] == ("writing the figure", None)


def test_poster_of_a_species_names_the_standing_of_each_fact(tmp_path):
    bee = omma.species.make("honeybee_worker")
    small = omma.species.Species(bee.name, bee.latin, bee.eye.take(range(0, 10760, 10)), bee.facts)
    plot_species(tmp_path / "a.svg", small)
    said = svg_texts(tmp_path / "a.svg")
    assert "Honeybee worker, Apis mellifera" in said
    assert "measured, sturzl2010" in said
    assert any("Bioinspir Biomim 5:036002" in words for words in said)


def test_commands(tmp_path, monkeypatch, run_omma):
    monkeypatch.chdir(tmp_path)
    omma.save_eye("a.eye", omma.eye.generate_eye(90))
    for what in ("3d", "acceptance", "poster"):
        code, out, err = run_omma("eye", "plot", "a.eye", "--what", what, "-o", f"{what}.svg")
        assert (code, out, err) == (0, f"wrote {what}.svg\n", "")
    assert "interommatidial angle Δφ (°)" in svg_texts(tmp_path / "3d.svg")
    code, _, err = run_omma(
        "eye", "plot", "a.eye", "--what", "acceptance", "--ommatidium", "3", "--ommatidium",
        "10,-20", "-o", "c.svg",
    )  # fmt: skip
    assert (code, err) == (0, "")
    assert any(words.startswith("3: gaussian") for words in svg_texts(tmp_path / "c.svg"))


def test_the_command_names_the_animal(tmp_path, monkeypatch, run_omma):
    monkeypatch.chdir(tmp_path)
    for what in ("acceptance", "3d"):
        given = ("--species", "drosophila", "--what", what, "-o", "a.svg")
        assert run_omma("eye", "plot", *given)[0] == 0
        assert any(words.startswith("Drosophila") for words in svg_texts(tmp_path / "a.svg"))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["-o", "a.svg"], ["--species"]),
        (["a.eye", "--species", "honeybee_worker", "-o", "a.svg"], ["--species"]),
        (["a.eye", "-o", "a.bmp"], ["a.bmp", ".pdf"]),
        (["a.eye", "-o", "a.svg", "--property", "no"], ["no", "interommatidial"]),
        (["a.eye", "-o", "a.svg", "--property", "eye", "--property", "ratio"], ["--property"]),
        (["a.eye", "--what", "acceptance", "-o", "a.svg", "--ommatidium", "x"], ["x", "azimuth"]),
        (["--species", "unicorn", "-o", "a.svg"], ["unicorn", "honeybee_worker"]),
    ],
)
def test_command_says_what_is_wrong(tmp_path, monkeypatch, run_omma, arguments, words):
    monkeypatch.chdir(tmp_path)
    omma.save_eye("a.eye", omma.eye.generate_eye(40))
    code, _, err = run_omma("eye", "plot", *arguments)
    assert code == 1
    for word in words:
        assert word in err


@pytest.mark.parametrize(
    ("plot", "message"),
    [
        (lambda name, eye: plot_acceptance(name, eye, [40]), "from 0 to 39, found 40"),
        (lambda name, eye: omma.picture.plot_eye_maps(name, eye, ["size"]), "property: expected"),
        (lambda name, eye: omma.picture.draw_eye(name, eye, colour="size"), "colour: expected"),
    ],
)
def test_choices_are_checked_before_an_eye_is_measured(tmp_path, monkeypatch, plot, message):
    def measured(eye):
        raise AssertionError("measured first")

    for module in ("acceptance_plots", "eye_maps", "drawing"):
        monkeypatch.setattr(f"omma.picture.{module}.measure_eye", measured)
    with pytest.raises(omma.Error, match=message):
        plot(str(tmp_path / "figure.svg"), omma.eye.generate_eye(40))
