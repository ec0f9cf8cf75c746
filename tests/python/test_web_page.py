"""The page in the browser, in Chromium: what it shows is, bit for bit, what `backend="portable"`
gives of the same files; it takes files, says what is wrong with others, and needs no network."""

import csv
import gzip
import re

import numpy as np
import pytest
from view_browser import Browser, keep, until
from web_pages import SITE, Served, drop, need_site, opened, seen, unpacked

import omma

FALSE_COLOURS = "receptors, false colours"


@pytest.fixture(scope="module")
def served():
    need_site()
    with Served() as served:
        yield served


@pytest.fixture(scope="module")
def browser():
    with Browser() as browser:
        yield browser


@pytest.fixture(scope="module")
def ant_page(browser, served):
    return opened(browser, f"{served.url}#scene=arena&eye=melophorus")


@pytest.fixture
def page(ant_page, browser):
    """The arena through an ant's eyes, on which tests go on; each leaves the console clean."""
    yield ant_page
    assert not browser.said


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("web")


def rendered(folder, scene, eye, matrix, rays, **options):
    """The same by the package."""
    world = omma.World(omma.load_scene(unpacked(f"{scene}.glb", folder)), backend="portable")
    loaded = omma.load_eye(unpacked(f"{eye}.csv", folder))
    renderer = omma.Renderer(world, loaded, omma.Fixed(rays), seed=options.pop("seed", 0))
    return renderer.render(matrix, **options)


def same_bits(one, other):
    return np.array_equal(one.view(np.uint32), np.asarray(other, np.float32).view(np.uint32))


@pytest.mark.parametrize(
    ("scene", "eye", "rays", "seed"),
    [
        ("arena", "melophorus", 4, 0),
        ("meadow", "melophorus", 16, 3),
        ("meadow", "drosophila", 4, 0),
    ],
)
def test_responses_are_those_of_the_package_bit_for_bit(
    browser, served, folder, scene, eye, rays, seed
):
    page = opened(browser, f"{served.url}#scene={scene}&eye={eye}&rays={rays}&seed={seed}")
    values, labels, matrix = seen(page)
    assert labels == ["red", "green", "blue"]
    assert values.max() > 0.1
    assert same_bits(values, rendered(folder, scene, eye, matrix, rays, seed=seed)[0])
    page.context.close()


def test_poses_are_those_of_the_package(page):
    rng = np.random.default_rng(5)
    poses = rng.uniform(-1, 1, (20, 6)) * (5, 5, 5, 180, 89, 180)
    poses = poses.round(4)
    made = page.evaluate(
        """async (rows) => {
      const { pose, matrixOf, poseFrom } = await import(new URL('./pose.js', location.href));
      return rows.map((row) => {
        const matrix = matrixOf(pose(...row));
        return [[...matrix], Object.values(poseFrom(matrix))];
      });
    }""",
        poses.tolist(),
    )
    matrices = np.array([one[0] for one in made]).reshape(-1, 4, 4)
    # Sines and cosines of two libraries.
    assert np.abs(matrices - omma.poses_from_angles(poses[:, :3], poses[:, 3:])).max() < 1e-15
    assert np.abs(np.array([one[1] for one in made]) - poses).max() < 1.01e-4  # how it is rounded


def test_receptors_and_scaled_acceptances(page, folder):
    values, labels, matrix = seen(page, shown=FALSE_COLOURS, widths=2)
    assert labels == ["ultraviolet", "green"]
    eye = omma.load_eye(unpacked("melophorus.csv", folder))
    wide = eye.replace(acceptance_angle_rad=2 * eye.acceptance_angle_rad)
    world = omma.World(omma.load_scene(unpacked("arena.glb", folder)), backend="portable")
    renderer = omma.Renderer(world, wide, omma.Fixed(4), seed=0)
    # A receptor's share of red, green and blue is an integral of exponentials, which two libraries
    # round differently: the last digit of single precision, and no more.
    assert np.allclose(values.ravel(), renderer.render_receptors(matrix)[0], rtol=3e-7, atol=0)
    values, *_ = seen(page, shown="colours", widths=2)
    assert same_bits(values, renderer.render(matrix)[0])
    plain, *_ = seen(page, shown="colours", widths=1)
    assert plain.shape == (1010, 3)


def test_receptors_beside_the_axis(browser, served, folder):
    # A fruit fly's, whose R7 and R8 are of several types of one name each.
    page = opened(browser, f"{served.url}#scene=arena&eye=drosophila")
    values, labels, matrix = seen(page, shown=FALSE_COLOURS)
    assert labels[:6] == [f"R{k}" for k in range(1, 7)]
    eye = omma.load_eye(unpacked("drosophila.csv", folder))
    names = [eye.receptor_types[t].name for t in eye.receptor_type]
    world = omma.World(omma.load_scene(unpacked("arena.glb", folder)), backend="portable")
    expected = omma.Renderer(world, eye, omma.Fixed(4), seed=0).render_receptors(matrix)[0]
    at = np.repeat(np.arange(len(eye.axis)), np.diff(eye.first_receptor))
    found = values[at, [labels.index(name) for name in names]]
    # As above.
    assert np.allclose(found, expected, rtol=3e-7, atol=0)
    assert np.count_nonzero(~np.isnan(values)) == len(expected)
    # R7 and R8 are of pale or yellow ommatidia; what all have makes the picture, without holes.
    assert np.isnan(values).any()
    holes = """() => {
  const { pixels, ids } = omma.app.picture;
  return pixels.some((colour, k) => ids[k] >= 0 && colour >>> 24 !== 255);
}"""
    assert not page.evaluate(holes)
    page.context.close()


def test_a_picked_ommatidium_says_its_numbers(page, folder):
    _, _, matrix = seen(page, picked=-1)
    box = page.locator("#eye").bounding_box()
    page.mouse.click(box["x"] + 0.3 * box["width"], box["y"] + 0.5 * box["height"])
    page.wait_for_selector("#numbers:has-text('8 × 4 rays')")
    text = page.inner_text("#numbers")
    index = int(re.search(r"Ommatidium (\d+)", text)[1])
    said = [float(one) for one in page.locator("#numbers .response").all_inner_texts()]
    wanted, errors = rendered(folder, "arena", "melophorus", matrix, 4, standard_error=True)
    # Seven digits of the response and three of its error are what is said.
    assert np.allclose(said, wanted[0, index], rtol=1e-6, atol=0)
    found = [float(one) for one in re.findall(r"± ([\d.e-]+)", text)]
    assert np.allclose(found, errors[0, index], rtol=6e-3, atol=0)
    eye = omma.load_eye(unpacked("melophorus.csv", folder))
    assert f"Δρ {np.degrees(eye.acceptance_angle_rad[index]):.2f}°" in text
    keep(page, "web-picked.png")
    seen(page, picked=-1)


def test_the_table_is_what_omma_render_writes(page, folder):
    values, *_ = seen(page)
    with page.expect_download() as download:
        page.click("[data-do=csv]")
    assert download.value.suggested_filename == "arena_melophorus.csv"
    with open(download.value.path(), newline="") as file:
        rows = list(csv.reader(file))
    assert ",".join(rows[0]) == "pose,ommatidium,eye_id,azimuth_deg,elevation_deg,r,g,b"
    # Nine digits say a single-precision number whole.
    assert same_bits(np.array([row[5:] for row in rows[1:]], np.float32), values)
    eye = omma.load_eye(unpacked("melophorus.csv", folder))
    assert [int(row[2]) for row in rows[1:]] == eye.eye_id.tolist()


def test_a_link_restores_the_state(browser, served, page):
    pose = {"x": 0.01, "y": 0.02, "z": 0.03, "yaw": 20, "pitch": -5, "roll": 3}
    before, *_ = seen(page, pose=pose)
    link = page.evaluate("omma.link()")
    other = opened(browser, f"{served.url}#{link}")
    after, *_ = seen(other)
    assert same_bits(before, after)
    assert other.evaluate("omma.link()") == link
    other.context.close()


def test_what_a_link_says_wrongly_is_told(browser, served):
    page = opened(browser, f"{served.url}#scene=my.glb&rays=three&projection=flat&eye=melophorus")
    until(lambda: "my.glb" in page.inner_text("#trouble"))
    assert "rays=three, projection=flat" in page.inner_text("#trouble")
    page.context.close()


def test_keys_and_drags_move_the_head(page):
    seen(page, pose={"x": 0, "y": 0, "z": 0, "yaw": 0, "pitch": 0, "roll": 0})
    page.locator("#eye").hover()
    for key in ("m", "m", "i", "+"):
        page.keyboard.press(key)
    pose = page.evaluate("omma.app.state.pose")
    assert pose["yaw"] == 6
    assert pose["z"] < 0 < pose["x"]
    assert page.evaluate("omma.app.state.rays") == 8
    page.keyboard.press("-")
    page.keyboard.down("w")
    until(lambda: page.evaluate("omma.app.state.pose.z") < pose["z"] - 1e-3)
    page.keyboard.up("w")
    box = page.locator("#eye").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 50, y, steps=3)
    page.mouse.up()
    assert page.evaluate("omma.app.state.pose.yaw") == pytest.approx(12, abs=1e-3)
    # And when nothing moves, nothing is rendered.
    page.evaluate("omma.app.working")
    frames = page.evaluate("omma.app.frames")
    page.wait_for_timeout(300)
    assert page.evaluate("omma.app.frames") == frames


def test_fingers_turn_the_head_and_fly(browser, served):
    page = opened(
        browser, f"{served.url}#scene=arena&eye=melophorus", 390, 844, has_touch=True,
        is_mobile=True,
    )  # fmt: skip
    seen(page, pose={"x": 0, "y": 0, "z": 0, "yaw": 0, "pitch": 0, "roll": 0})
    fingers = page.context.new_cdp_session(page)

    def touch(kind, **places):
        points = [{"id": int(name[1:]), "x": x, "y": y} for name, (x, y) in places.items()]
        fingers.send("Input.dispatchTouchEvent", {"type": f"touch{kind}", "touchPoints": points})

    def middle(of):
        box = page.locator(of).bounding_box()
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def pose():
        return page.evaluate("omma.app.state.pose")

    x, y = middle("#eye")
    ahead, back = middle("[data-hold='1']"), middle("[data-hold='-1']")
    touch("Start", f0=(x, y))
    touch("Move", f0=(x - 50, y + 25))
    touch("End")
    # 0.12 degrees a pixel; how Chromium rounds the places of fingers is its own.
    assert pose()["yaw"] == pytest.approx(6, abs=0.13)
    assert pose()["pitch"] == pytest.approx(3, abs=0.13)
    # One finger goes ahead, another one turns the head meanwhile.
    touch("Start", f0=ahead)
    until(lambda: pose()["z"] < -1e-3)
    touch("Start", f0=ahead, f1=(x, y))
    touch("Move", f0=ahead, f1=(x - 50, y))
    assert pose()["yaw"] == pytest.approx(12, abs=0.25)
    before = pose()["z"]
    until(lambda: pose()["z"] < before)
    touch("End")
    page.evaluate("new Promise(requestAnimationFrame)")
    before = pose()["z"]
    touch("Start", f0=back)
    until(lambda: pose()["z"] > before)
    touch("End")
    page.touchscreen.tap(0.6 * x, y)  # the left eye's picture
    until(lambda: page.evaluate("omma.app.state.picked") >= 0)
    assert page.evaluate("scrollY") == 0
    page.context.close()


def test_own_files_are_read(page, folder):
    scene, eye = folder / "own.glb", folder / "own.csv"
    omma.scene.save_scene(scene, omma.scene.sphere(1.0, (0.2, 0.4, 0.6), center_m=(0, 0, -3)))
    omma.save_eye(eye, omma.eye.generate_eye(200))
    drop(page, ("own.glb", scene.read_bytes()), ("own.csv", eye.read_bytes()))
    values, _, matrix = seen(page)
    world = omma.World(omma.load_scene(scene), backend="portable")
    wanted = omma.Renderer(world, omma.load_eye(eye), omma.Fixed(4), seed=0).render(matrix)[0]
    assert same_bits(values, wanted)
    assert page.locator("#scene-name").input_value() == "own.glb"
    page.select_option("#scene-name", "arena")
    page.select_option("#eye-name", "melophorus")
    page.evaluate("omma.app.working")


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("cut.glb", b"glTF\x02\x00\x00\x00\x10\x00"),
        ("text.glb", b"no scene at all, but a text of some length"),
        ("old.gltf", b'{"asset": {"version": "1.0"}}'),
        ("words.csv", b"a,b,c\n1,2,3\n"),
        ("short.eye", b"0 0 0 0 0 -1\n"),
    ],
)  # fmt: skip
def test_a_broken_file_is_told_and_leaves_all_as_it_was(page, folder, name, data):
    before, *_ = seen(page)
    drop(page, (name, data))
    said = page.inner_text("#trouble p")
    page.keyboard.press("Escape")
    path = folder / name
    path.write_bytes(data)
    with pytest.raises(omma.Error) as error:
        omma.load_eye(path) if path.suffix in (".csv", ".eye") else omma.load_scene(path)
    # The same words; a page knows no folders.
    assert said == str(error.value).replace(f"{folder}/", "")
    assert same_bits(seen(page)[0], before)


def test_what_is_no_file_of_the_page_or_too_large_is_told(page):
    drop(page, ("notes.txt", b"hello"))
    assert "expected a scene (.glb" in page.inner_text("#trouble p")
    drop(page, ("none.glb", b""))
    assert "none.glb: the file is empty" in page.inner_text("#trouble p")
    said = page.evaluate(
        """async () => {
      const { kindOf, MOST_BYTES } = await import(new URL('./files.js', location.href));
      const file = { name: 'big.glb', size: MOST_BYTES.scene + 1 };
      try { return kindOf(file); } catch (error) { return error.message; }
    }"""
    )
    assert "256 MiB" in said
    page.keyboard.press("Escape")


def test_the_network_may_go_when_all_is_loaded(browser, served):
    asked = []
    page = browser.open("about:blank", wait=False)
    page.on("request", lambda request: asked.append(request.url))
    page.goto(f"{served.url}#scene=arena&eye=melophorus")
    page.wait_for_selector("body[data-whole]")
    assert all(url.startswith((served.url, "data:", "blob:")) for url in asked)
    page.context.set_offline(True)
    before = len(asked)
    page.select_option("#scene-name", "meadow")
    page.select_option("#eye-name", "drosophila")
    until(lambda: page.evaluate("omma.app.eye.ommatidia") == 1709)
    until(lambda: page.evaluate("omma.app.seen.responses.length") == 3 * 1709)
    assert len(asked) == before
    page.context.close()


def test_it_fits_screens_of_three_sizes(browser, served):
    for width, height in ((1440, 900), (1024, 768), (390, 844)):
        page = opened(browser, f"{served.url}#scene=arena&eye=melophorus", width, height)
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        box = page.locator("#eye").bounding_box()
        assert 0 <= box["x"] < box["x"] + box["width"] <= width
        assert box["width"] > 0.5 * width
        keep(page, f"web-{width}.png")
        page.context.close()


def test_every_species_and_projection_is_shown(page):
    of_list = "all => all.map((each) => each.value)"
    for projection in page.locator("#projection option").evaluate_all(of_list):
        seen(page, projection=projection)
        assert page.evaluate("omma.app.picture.kind") == projection
    seen(page, projection="facets")
    names = page.locator("#eye-name option").evaluate_all(of_list)
    assert len(names) == 10
    for name in names:
        rows = gzip.decompress((SITE / "data" / f"{name}.csv.gz").read_bytes()).split(b"\n")
        number = sum(1 for row in rows if row and row[:1] != b"#") - 1  # without the names
        page.select_option("#eye-name", name)
        until(lambda number=number: page.evaluate("omma.app.seen.responses.length") == 3 * number)
    assert page.locator("#trouble").is_hidden()
    page.select_option("#eye-name", "melophorus")
    page.evaluate("omma.app.working")
