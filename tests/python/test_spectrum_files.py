"""Spectra from files of spectrometers, R and spreadsheets, and light by a measured irradiance."""

import warnings

import numpy as np
import pytest

import omma
from omma.light import load_spectra

PLAIN = "wl,white,red\n300,5,3\n500,70,4\n700,72,61\n"


def written(folder, text, name="petals.csv", encoding="utf-8"):
    path = folder / name
    path.write_bytes(text.encode(encoding))
    return path


def quietly(path, **arguments):
    """What is read, where nothing may be said."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return load_spectra(path, **arguments)


# Each as it is written: the same two spectra in per cent.
FORMS = {
    "csv": PLAIN,
    "semicolons and decimal commas": "wl;white;red\n300;5,0;3\n500;70,0;4\n700;72;61\n",
    "tabs": PLAIN.replace(",", "\t"),
    "tabs and decimal commas": "nm\twhite\tred\n300,0\t5,0\t3,0\n500\t70\t4\n700\t72\t61\n",
    "spaces": PLAIN.replace(",", "  "),
    "spaces and decimal commas": "wl white red\n300,0 5 3,0\n500,0 70 4\n700,0 72,0 61\n",
    "blanks after commas": PLAIN.replace(",", ", "),
    "windows": PLAIN.replace("\n", "\r\n"),
    "byte order mark": "\ufeff" + PLAIN,
    "descending": "wl,white,red\n700,72,61\n500,70,4\n300,5,3\n",
    "wavelengths last": "white,red,Wavelength (nm)\n5,3,300\n70,4,500\n72,61,700\n",
    "row names of write.csv": '"","wl","white","red"\n"1",300,5,3\n"2",500,70,4\n"3",700,72,61\n',
    "row names of write.table": '"wl" "white" "red"\n"1" 300 5 3\n"2" 500 70 4\n"3" 700 72 61\n',
    "comments": "# a field\n\n" + PLAIN + "# the end\n",
    "an instrument's lines": "Device: 12\nDate: 2026-06-21, noon\n" + PLAIN,
    "exponents": "wl,white,red\n3e2,5.0E+00,.3e1\n500,7e1,4\n700,72.,61\n",
    "delimiters at the end": PLAIN.replace("\n", ",\n"),
}


@pytest.mark.parametrize("form", FORMS)
def test_each_form_holds_the_same(tmp_path, form):
    found = quietly(written(tmp_path, FORMS[form]), unit="percent")
    assert list(found) == ["white", "red"]
    assert found["white"] == omma.light.Spectrum([300, 500, 700], [0.05, 0.7, 0.72])
    assert found["red"] == omma.light.Spectrum([300, 500, 700], [0.03, 0.04, 0.61])


def test_downloads_of_the_floral_reflectance_database(tmp_path):
    """Lines of a flower's number, nm and a fraction, with a blank at their ends, as in
    FReDflowerID_157.csv of the R package photobiologyInOut."""
    lines = "157, 300, 0.0627119 \n157, 301, 0.0654036 \n157, 302, 0.0677941 \n"
    found = quietly(written(tmp_path, lines), unit="fraction")
    expected = omma.light.Spectrum([300, 301, 302], [0.0627119, 0.0654036, 0.0677941])
    assert found == {"157": expected}
    both = quietly(written(tmp_path, lines + lines.replace("157", "9")), unit="fraction")
    assert list(both) == ["157", "9"]
    assert both["9"] == both["157"] == expected
    with pytest.raises(omma.Error, match=r"line 4: expected flower 9 at the wavelengths of flower"):
        load_spectra(written(tmp_path, lines + "9, 300, 0.1\n9, 305, 0.1\n"))


OCEAN = """Data from FLMS12345__0.txt Node

Date: Mon Jun 21 12:00:00 CEST 2026
User: bee
Integration Time (sec): 1{sign}000000E-1
Number of Pixels in Spectrum: 4
>>>>>Begin Spectral Data<<<<<
190{sign}5\t-312{sign}7
300{sign}0\t5{sign}0
500{sign}0\t70{sign}0
700{sign}0\t72{sign}0
>>>>>End Spectral Data<<<<<
"""


@pytest.mark.parametrize("sign", ".,")
def test_ocean_optics(tmp_path, sign):
    path = written(tmp_path, OCEAN.format(sign=sign), "petal one.txt")
    found = quietly(path, unit="percent", range_nm=(300, 700))
    assert list(found) == ["petal one"]
    assert found["petal one"] == omma.light.Spectrum([300, 500, 700], [0.05, 0.7, 0.72])
    # Its noise below 200 nm is told by line.
    with pytest.raises(
        omma.Error, match=r"petal one.txt, line 8: .*found -312.7 of 'petal one' at"
    ):
        load_spectra(path, unit="percent")


def test_avantes(tmp_path):
    """Names and below them units, counts beside what is wanted."""
    path = written(
        tmp_path,
        "petal\nIntegration time: 175 ms\nAverage: 20 scans\n"
        "Wave   ;Dark     ;Ref      ;Sample   ;Reflectance\n"
        "[nm]   ;[counts] ;[counts] ;[counts] ;[% reflectance] \n"
        "300,00;3,4050;6429,1;124,99;5,0000\n700,00;-18,870;6876,0;178,64;72,000\n",
    )
    name = "Reflectance [% reflectance]"
    found = quietly(path, columns=[name])
    assert found[name] == omma.light.Spectrum([300, 700], [0.05, 0.72])
    with pytest.raises(omma.Error, match=r"found 6876 \(of percent\); columns= and range_nm="):
        load_spectra(path)
    assert list(load_spectra(path, unit="as_is", columns=["Ref [counts]"])) == ["Ref [counts]"]


def test_bytes_that_windows_writes(tmp_path):
    for encoding in ("cp1252", "utf-16"):
        path = written(tmp_path, "wl,Blüte\n300,0.1\n700,0.2\n", encoding=encoding)
        assert list(quietly(path, unit="fraction")) == ["Blüte"]


def test_columns_without_names(tmp_path):
    path = written(tmp_path, "300,0.1\n700,0.2\n", "daisy.csv")
    assert list(quietly(path, unit="fraction")) == ["daisy"]
    path = written(tmp_path, "300,0.1,0.2\n700,0.2,0.3\n")
    assert list(quietly(path, unit="fraction")) == ["column 2", "column 3"]


@pytest.mark.parametrize("ending", [("", ""), (",", ","), (",notes", ","), (",notes,", ",")])
def test_names_stay_where_columns_without_numbers_come_last(tmp_path, ending):
    """As spreadsheets write columns that were used once, with a name or without."""
    of_names, of_numbers = ending
    first, *rows = PLAIN.splitlines()
    lines = [first + of_names, *(row + of_numbers for row in rows)]
    found = quietly(written(tmp_path, "\n".join(lines)), unit="percent")
    assert list(found) == ["white", "red"]
    assert found["red"].value == pytest.approx([0.03, 0.04, 0.61])


def test_names_of_other_columns_are_told(tmp_path):
    path = written(tmp_path, PLAIN.replace("red", "red,blue"))
    with pytest.warns(
        UserWarning, match=r"each of 3 columns of numbers, found 4 names; .*column 2"
    ):
        assert list(load_spectra(path, unit="percent")) == ["column 2", "column 3"]


def test_per_cent_and_fractions(tmp_path):
    def value(text, **arguments):
        return load_spectra(written(tmp_path, text), **arguments)["a"].value.tolist()

    percent, fraction = "wl,a\n300,2\n700,60\n", "wl,a\n300,0.02\n700,0.6\n"
    with pytest.warns(UserWarning, match="up to 60, are taken as per cent; unit='percent' says so"):
        assert value(percent) == [0.02, 0.6]
    with pytest.warns(UserWarning, match="up to 0.6, are taken as fractions; unit='fraction'"):
        assert value(fraction) == [0.02, 0.6]
    # Black: what is named counts, as does a name that says so.
    assert value("wl,a\n300,0.5\n700,0.8\n", unit="percent") == [0.005, 0.008]
    path = written(tmp_path, "wl,R (%)\n300,0.5\n700,0.8\n")
    assert quietly(path)["R (%)"].value.tolist() == [0.005, 0.008]
    with pytest.raises(
        omma.Error, match=r"found 1.2 as the largest, which may be either; say unit="
    ):
        value("wl,a\n300,0.5\n700,1.2\n")
    assert value("wl,a\n300,0.5\n700,1.2\n", unit="fraction") == [0.5, 1.2]
    with pytest.raises(omma.Error, match=r"of at most 1.5, found 60 \(of fraction\)"):
        value(percent, unit="fraction")
    with pytest.raises(omma.Error, match=r"of at most 150, found 30000 \(of percent\).*as_is"):
        value("wl,a\n300,2\n700,30000\n", unit="percent")
    assert value("wl,a\n300,2\n700,30000\n", unit="as_is") == [2, 30000]
    with pytest.raises(omma.Error, match="unit: expected one of fraction, percent, as_is"):
        value(percent, unit="%")


def test_noise_about_0(tmp_path):
    path = written(tmp_path, "wl,a,b\n300,-0.04,0.2\n500,-0.01,0.3\n700,0.5,0.4\n")
    with pytest.warns(UserWarning, match=r"2 values below 0, down to -0.04, are taken as 0"):
        assert load_spectra(path, unit="fraction")["a"].value.tolist() == [0, 0, 0.5]
    # In the file's own numbers.
    with pytest.warns(UserWarning, match=r"1 values below 0, down to -3, are taken as 0"):
        load_spectra(written(tmp_path, "wl,a\n300,-3\n700,50\n"), unit="percent")
    path = written(tmp_path, "wl,a\n300,-0.06\n700,0.5\n")
    with pytest.raises(omma.Error, match=r"petals.csv, line 2: .*at least -0.05.* found -0.06 of"):
        load_spectra(path, unit="fraction")
    path = written(tmp_path, "wl,a\n300,-0.000\n700,0.5\n")
    assert not np.signbit(quietly(path, unit="fraction")["a"].value).any()
    path = written(tmp_path, "wl,a\n300,-4\n700,100\n")
    with pytest.warns(UserWarning, match="1 values below 0"):
        load_spectra(path, unit="as_is")
    path = written(tmp_path, "wl,a\n300,-6\n700,100\n")
    with pytest.raises(omma.Error, match="line 2: expected values of at least -5, which is noise"):
        load_spectra(path, unit="as_is")


def test_ranges_and_columns(tmp_path):
    path = written(tmp_path, "wl,a,b\n290,5,NA\n310,7,2\n690,40,3\n710,60,4\n")
    found = quietly(path, unit="percent", range_nm=(300, 700), columns=["a"])
    np.testing.assert_allclose(found["a"].wavelength_nm, [300, 310, 690, 700])
    np.testing.assert_allclose(found["a"].value, [0.06, 0.07, 0.4, 0.5])  # straight between
    found = quietly(path, unit="percent", range_nm=(310, 690))
    np.testing.assert_allclose(found["b"].value, [0.02, 0.03])
    with pytest.raises(omma.Error, match=r"line 2: expected a number, found none of 'b' at 290 nm"):
        load_spectra(path, unit="percent")
    with pytest.raises(omma.Error, match=r"that .*csv has, 290 to 710 nm, found 300 to 750"):
        load_spectra(path, unit="percent", range_nm=(300, 750))
    with pytest.raises(omma.Error, match="columns: expected one of a, b, found 'c'"):
        load_spectra(path, columns=["c"])
    for wrong in ((700, 300), (300,)):
        with pytest.raises(omma.Error, match="range_nm: expected two wavelengths, low and high"):
            load_spectra(path, range_nm=wrong)


def test_fractions_beside_per_cent_are_told(tmp_path):
    path = written(tmp_path, "wl,petal,leaf,soil\n300,6,0.02,3\n500,70,0.14,4\n")
    told = r"per cent, up to 70, but leaf \(up to 0.14\) may be fractions"
    with pytest.warns(UserWarning, match=told):
        load_spectra(path, unit="percent")
    with pytest.warns(UserWarning, match=told):
        load_spectra(path)
    # What the warning says to do, and what is per cent alone.
    assert quietly(path, unit="fraction", columns=["leaf"])["leaf"].value.tolist() == [0.02, 0.14]
    quietly(path, unit="percent", columns=["petal", "soil"])
    quietly(written(tmp_path, "wl,black,dark\n300,0.4,3\n500,0.5,9\n"), unit="percent")


def test_lines_that_are_there_twice_count_once(tmp_path):
    """As where a spectrometer's files were spliced, which its reader writes twice."""
    for text in ("300,1\n400,2\n400,2\n500,3\n", "500,3\n400,2\n400,2\n300,1\n"):
        found = quietly(written(tmp_path, "wl,a\n" + text), unit="percent")["a"]
        assert found.wavelength_nm.tolist() == [300, 400, 500]
        np.testing.assert_allclose(found.value, [0.01, 0.02, 0.03])


def test_cells_that_are_empty(tmp_path):
    """Like NA: the error names column and wavelength; columns= and range_nm= leave them out."""
    for cells in ("400,\n500,6", "400,NA\n500,6", "400,,\n500,6,", "400\t\n500\t6"):
        tab = "\t" in cells
        text = f"wl,a\n300,5\n{cells}\n600,7\n"
        path = written(tmp_path, text.replace(",", "\t") if tab else text)
        with pytest.raises(omma.Error, match="line 3: expected a number, found none of 'a' at 400"):
            load_spectra(path, unit="percent")
        assert quietly(path, unit="percent", range_nm=(500, 600))["a"].value.tolist() == [
            0.06, 0.07,
        ]  # fmt: skip
    path = written(tmp_path, "wl,a\n300,\n400,5\n500,6\n")  # in the first line too
    with pytest.raises(omma.Error, match="line 2: expected a number, found none of 'a' at 300 nm"):
        load_spectra(path, unit="percent")


@pytest.mark.parametrize(
    "text",
    [
        "wl,a\n300,6,123\n301,6,130\n",
        "wl,a\n300,0,6,123\n300,5,6,130\n",
        "wl,a,b\n300,6,1,0,2\n301,6,2,0,3\n",
        "300,6,023\n301,6,123\n",
    ],
)
def test_commas_that_may_be_either_are_refused(tmp_path, text):
    with pytest.raises(omma.Error, match=r"petals.csv, line [12]: commas are between numbers and"):
        load_spectra(written(tmp_path, text), unit="percent")


def test_commas_between_whole_numbers_are_plain(tmp_path):
    """Rows numbered as R writes them, also from 101 on, and two columns without names."""
    for first in (1, 101):
        path = written(tmp_path, f"wl,a\n{first},300,5\n{first + 1},400,6\n")
        assert quietly(path, unit="percent")["a"].wavelength_nm.tolist() == [300, 400]
    assert len(quietly(written(tmp_path, "300,6,23\n301,6,0\n"), unit="percent")) == 2


WRONG = {
    "no number": ("wl,a\n300,1\n400,x\n", "line 3: expected numbers, found 'x'"),
    "no number in the first line": ("wl,a\n300,x\n400,1\n", "line 2: expected numbers, found 'x'"),
    "a cell too many": ("wl,a\n300,1\n400,1,2\n", "line 3: expected 2 numbers, found 3"),
    "twice": (
        "wl,a\n300,1\n300,2\n",
        "line 3: .* each once, found 300 after 300 nm, with other values than in line 2: keep one",
    ),
    "unsorted": ("wl,a\n300,1\n500,2\n400,2\n", "line 4: .* found 400 after 500 nm"),
    "micrometres": ("wl,a\n0.3,1\n0.7,2\n", "found 0.3 to 0.7, which look like micrometres"),
    "wavenumbers": ("wl,a\n14000,1\n33000,2\n", "expected wavelengths of 100 to 5000 nm"),
    "no wavelength": ("wl,a\n300,1\nNA,2\n", "line 3: expected wavelengths that ascend"),
    "one line": ("wl,a\n300,1\n", "expected two wavelengths or more, found 1"),
    "one column": ("wl\n300\n400\n", "expected lines of wavelengths and values, found none"),
    "nothing": ("", "expected a table of wavelengths and values, found no line of one"),
    "words": ("a field of flowers\n", "expected lines of wavelengths and values, found none"),
    "cut in its last line": (
        "wl,a\n300,1\n400,1\n500,1\n600,1\n70",
        "line 6: expected 2 numbers, found 1",
    ),
    "cut, with tabs": ("wl\ta\n300\t1\n400\t1\n5", "line 4: expected 2 numbers, found 1"),
    "cut, with decimal commas": (
        "wl;a\n300,0;1,5\n400,0;1,5\n500,0",
        "line 4: expected 2 numbers, found 1",
    ),
    "per cent far below 0": (
        "wl,a\n300,-8\n400,1\n",
        "line 2: expected values of at least -5, which is noise, found -8 of 'a' at 300 nm",
    ),
    "two of a name": ("wl,a,a\n300,1,2\n400,1,2\n", "of different names, found 'a' twice"),
    "two wavelengths": ("wl,a,wl\n300,1,2\n400,1,2\n", "expected one column of wavelengths"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_told(tmp_path, case):
    text, said = WRONG[case]
    with pytest.raises(omma.Error, match=rf"petals\.csv.*{said}"):
        load_spectra(written(tmp_path, text), unit="percent")


def test_bands_take_spectra_and_refuse_short_ones():
    bands = omma.light.Bands.equal(4)
    ramp = omma.light.Spectrum([300, 700], [0, 4])
    np.testing.assert_allclose(bands.mean(ramp), [0.5, 1.5, 2.5, 3.5])
    with pytest.raises(
        omma.Error, match=r"from 300 to 700 nm, where the bands are, found 400 to 700 nm"
    ):
        bands.mean(omma.light.Spectrum([400, 700], [0, 4]))


def test_a_sky_by_its_irradiance():
    bands = omma.light.Bands.equal(8)
    flat = omma.light.Spectrum([300, 700], [2.0, 2.0])
    for word, unit, expected in (
        ("watts", "watts", 2.0),
        ("microwatts_per_cm2", "watts", 0.02),
        ("photons", "photons", 2.0),
        ("micromoles", "photons", 2 * 6.02214076e17),
    ):
        light = omma.light.measured_sky(flat, word, bands=bands, unit=unit)
        sky, discs = light.irradiance()
        # The sky's map is in single precision.
        np.testing.assert_allclose(sky, expected, rtol=1e-6)
        assert not discs.any()
        assert not light.irradiance((0, -1, 0))[0].any()
    # A watt at λ is λ/(hc) photons: of the middle of each band, where the spectrum is flat.
    fine = omma.light.Spectrum(np.arange(300, 701.0), np.full(401, 2.0))
    photons = omma.light.measured_sky(fine, "watts", bands=bands).irradiance()[0]
    expected = omma.light.photons_from_watts(2.0, bands.centers_nm)
    np.testing.assert_allclose(photons, expected, rtol=1e-6)
    again = omma.light.measured_sky(fine, "watts", bands=bands).in_bands(omma.light.Bands.equal(2))
    assert len(again.bands) == 2
    with pytest.raises(omma.Error, match="irradiance_unit: expected one of watts, microwatts_per"):
        omma.light.measured_sky(flat, "lux")
    with pytest.raises(omma.Error, match=r"spectrum: expected values from 300 to 700 nm"):
        omma.light.measured_sky(omma.light.Spectrum([400, 700], [1, 1]), "watts")


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("units", ["nm,%,%", "(nm),%,%", "nanometers,percent,"])
def test_a_line_of_units_below_the_names(tmp_path, units):
    """The units had replaced the names."""
    found = load_spectra(written(tmp_path, f"wl,a,b\n{units}\n300,5,3\n700,72,61\n"))
    assert list(found) == ["a", "b"]
    assert found["a"].value.tolist() == [0.05, 0.72]
    one = load_spectra(
        written(tmp_path, "wavelength;a\nnm;%\n300;5\n700;72\n"), range_nm=(400, 500)
    )
    assert list(one) == ["a"]


def test_irradiances_in_another_unit_are_told():
    for unit, most in (
        ("watts", 120.0),
        ("microwatts_per_cm2", 12e3),
        ("photons", 3e20),
        ("micromoles", 500.0),
    ):
        with pytest.warns(UserWarning, match=f"irradiance, in {unit}: .* is unusual"):
            omma.light.measured_sky(omma.light.Spectrum([300, 700], [0.0, most]), unit)
