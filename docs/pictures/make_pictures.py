"""Draw the pictures of the documentation anew: ``python docs/pictures/make_pictures.py``.

Needs Chromium and its driver (``apt-get install chromium chromium-driver``), selenium and pillow.
"""

from __future__ import annotations

import io
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

import psp3
from psp3.visualize import Scene

HERE = Path(__file__).parent
HEIGHT, WHOLE_WIDTH, CLOSE_WIDTH = 620, 400, 500
ANIMATION_WIDTH, SECONDS, FRAME_RATE, COLORS = 720, 4.0, 10, 255
OTHER_WIDTH = 400
OTHERS = {
    "psp3": 0.06,
    "five_bar": 0.3,
    "planar_3rrr": 0.2,
    "delta": 0.3,
    "gough_stewart": 0.05,
    "tricept": 0.08,
    "planar_4rrr": 0.2,
    "jansen": 0.6,
    "agile_eye": 0.4,
    "hexa": 0.2,
    "gripper": 0.02,
    "biped": 0.1,
}
"""How far each robot is from its reference pose [rad or m]; a floating base stays where it is."""
ROW = 6
"""How many of them stand side by side."""
HEIGHTS = psp3.load().inverse_kinematics(
    height=0.03, tilt=np.radians(18.0), azimuth=np.radians(200.0)
)

RENDER_WITHOUT_A_SCREEN = (
    "--headless",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)

HIDE_CONTROLS = """
for (const name of ['playback', 'distance']) document.getElementById(name).style.visibility = \
'hidden';
animator.pause();
"""

LOOK_AT_THE_STAR = """
const [center, zoom] = arguments;
viewer.controls.target.set(center[0], center[2], -center[1]);
viewer.camera.position.y += 0.9;
viewer.camera.zoom = zoom;
light.shadow.radius = 1;
"""


def picture(
    browser: webdriver.Chrome, scene: Scene, width: int, script: str = "", *arguments: object
) -> Image.Image:
    """Render a scene, after running a script in its page."""
    metrics = {"width": width, "height": HEIGHT, "deviceScaleFactor": 2, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    with tempfile.TemporaryDirectory() as directory:
        page = Path(directory) / "scene.html"
        scene.write_html(page)
        browser.get(page.as_uri())
        browser.execute_async_script(
            "requestAnimationFrame(() => requestAnimationFrame(arguments[0]))"
        )
        browser.execute_script(
            "light.shadow.mapSize.set(4096, 4096); light.shadow.map.dispose(); light.shadow.map "
            "= null"
        )
        browser.execute_script(
            f"viewer.gui.domElement.style.visibility = 'hidden'; {script}; viewer.render()",
            *arguments,
        )
        return Image.open(io.BytesIO(browser.get_screenshot_as_png())).convert("RGB")


def robot(browser: webdriver.Chrome) -> Image.Image:
    """Return the whole robot and, beside it, its star from nearby."""
    scene = Scene(psp3.load())
    scene.show(HEIGHTS)
    center = scene.robot.forward_kinematics(HEIGHTS).center.tolist()
    whole = picture(browser, scene, WHOLE_WIDTH)
    close = picture(browser, scene, CLOSE_WIDTH, LOOK_AT_THE_STAR, center, 1.95)
    both = Image.new("RGB", (whole.width + close.width, whole.height))
    both.paste(whole, (0, 0))
    both.paste(close, (whole.width, 0))
    return both.resize((both.width // 2, both.height // 2), Image.Resampling.LANCZOS)


def others(browser: webdriver.Chrome) -> Image.Image:
    """Return all robots in rows, each in a pose of its own, from nearby."""
    images = []
    for name, share in OTHERS.items():
        robot = psp3.load(name)
        pose = robot.reference.copy()
        floats = len(pose) > len(robot.coordinates_v)
        moved = pose[:-7] if floats else pose
        moved += share * np.random.default_rng(2).uniform(-1.0, 1.0, len(moved))
        images.append(picture(browser, Scene(robot).show(pose), OTHER_WIDTH))
    width, height = images[0].size
    rows = -(-len(images) // ROW)
    both = Image.new("RGB", (ROW * width, rows * height))
    for number, image in enumerate(images):
        both.paste(image, (number % ROW * width, number // ROW * height))
    return both.resize((both.width // 3, both.height // 3), Image.Resampling.LANCZOS)


def animation(browser: webdriver.Chrome) -> list[Image.Image]:
    """Return PD beside computed torque on the helix, frame by frame.

    It starts from a place where both are whole.
    """
    robot = psp3.load()
    helix = psp3.trajectories.Helix(robot=robot)
    controllers = {"PD": psp3.PD(), "computed torque": psp3.ComputedTorque(robot)}
    scene = Scene(robot)
    scene.animate(
        {
            name: psp3.simulate(robot, controller, helix, SECONDS)
            for name, controller in controllers.items()
        }
    )
    picture(browser, scene, ANIMATION_WIDTH, HIDE_CONTROLS)
    frames = []
    for time in np.arange(0.0, SECONDS, 1.0 / FRAME_RATE).tolist():
        browser.execute_script(
            "animator.seek(arguments[0]); animator.time = arguments[0]; viewer.render()", time
        )
        frame = Image.open(io.BytesIO(browser.get_screenshot_as_png())).convert("RGB")
        frames.append(frame.resize((ANIMATION_WIDTH, HEIGHT), Image.Resampling.LANCZOS))
    return frames


def with_one_palette(frames: list[Image.Image]) -> list[Image.Image]:
    """Return frames in the colors that the middle one needs most.

    They are the same for all, so that nothing flickers.
    """
    palette = frames[len(frames) // 2].quantize(COLORS, Image.Quantize.FASTOCTREE)
    return [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]


def main() -> None:
    """Write every picture beside this file."""
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for argument in RENDER_WITHOUT_A_SCREEN:
        options.add_argument(argument)
    browser = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
    try:
        robot(browser).save(HERE / "robot.png", optimize=True)
        others(browser).quantize(COLORS).save(HERE / "robots.png", optimize=True)
        first, *rest = with_one_palette(animation(browser))
        first.save(
            HERE / "tracking.gif",
            save_all=True,
            append_images=rest,
            duration=1000 // FRAME_RATE,
            loop=0,
            optimize=True,
        )
    finally:
        browser.quit()


if __name__ == "__main__":
    main()
