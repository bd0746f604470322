#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Uses a page of `fewray report` as people do, in headless Chromium: mouse, touch and keys, at the size of a desktop and of a
phone, dark and light, without JavaScript and on paper. The folder held plain.exr, guided.exr with what its denoiser was
given, reference.exr and bench.json.

    test_report.py REPORT.html SCREENSHOTS    ends with 0 where all holds; SCREENSHOTS is a folder for PNGs
"""
import json
import os
import pathlib
import sys
import time
import unittest

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions.wheel_input import ScrollOrigin
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select

PAGE, SHOTS = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
NAMES = ["guided, before the denoiser", "guided", "plain", "reference"]
DESKTOP, PHONE = (1280, 900), (390, 844)


def open_browser():
    options = webdriver.ChromeOptions()
    options.add_argument("--headless=new")
    options.add_argument("--disable-gpu")
    options.add_argument("--disable-dev-shm-usage")
    options.add_argument("--hide-scrollbars")
    if os.geteuid() == 0:
        options.add_argument("--no-sandbox")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    return webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))


class Report(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.browser = open_browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.quit()

    def load(self, size, scheme="light", touch=False, script=True):
        devtools = self.browser.execute_cdp_cmd
        devtools("Emulation.setDeviceMetricsOverride",
                 {"width": size[0], "height": size[1], "deviceScaleFactor": 2 if touch else 1, "mobile": touch})
        devtools("Emulation.setTouchEmulationEnabled", {"enabled": touch})
        devtools("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]})
        devtools("Emulation.setScriptExecutionDisabled", {"value": not script})
        self.browser.get(PAGE.as_uri())

    def tearDown(self):
        self.browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})
        self.assertEqual(self.browser.get_log("browser"), [], "the console has messages")
        urls = [message["params"]["request"]["url"] for message in
                (json.loads(entry["message"])["message"] for entry in self.browser.get_log("performance"))
                if message["method"] == "Network.requestWillBeSent"]
        self.assertEqual([url for url in urls if not url.startswith(("data:", PAGE.as_uri()))], [])

    def shoot(self, name):
        SHOTS.mkdir(exist_ok=True)
        self.browser.save_screenshot(str(SHOTS / f"{name}.png"))

    def by_id(self, name):
        return self.browser.find_element(By.ID, name)

    def evaluate(self, text, *arguments):
        return self.browser.execute_script("return " + text, *arguments)

    def split(self):
        return int(self.by_id("handle").get_attribute("aria-valuenow"))

    def shown(self, side):
        return self.by_id(side + "-name").text

    def zoom(self):
        return self.style("--zoom")

    def box(self, element):
        self.evaluate("arguments[0].scrollIntoView({block: 'center'})", element)
        box = self.evaluate("arguments[0].getBoundingClientRect().toJSON()", element)
        return box["x"], box["y"], box["width"], box["height"]

    def at(self, share_x, share_y=0.5):
        """Place on the stage, in pixels of the window."""
        x, y, width, height = self.box(self.by_id("stage"))
        return round(x + share_x * width), round(y + share_y * height)

    def point(self, kind, *paths, step_ms=60, times=1):
        """Goes down, along a path of places and up (W3C WebDriver, section 15), each path with a pointer of its own."""
        sources = []
        for i, path in enumerate(paths):
            down = [{"type": "pointerMove", "duration": 0, "x": path[0][0], "y": path[0][1]}, {"type": "pointerDown", "button": 0}]
            moves = [{"type": "pointerMove", "duration": step_ms, "x": x, "y": y} for x, y in path[1:]]
            sources.append({"type": "pointer", "id": f"{kind}{i}", "parameters": {"pointerType": kind},
                            "actions": (down + moves + [{"type": "pointerUp", "button": 0}]) * times})
        self.browser.execute("actions", {"actions": sources})

    def wheel(self, element, down):
        ActionChains(self.browser).scroll_from_origin(ScrollOrigin.from_element(element), 0, down).perform()
        time.sleep(0.3)

    def style(self, name):
        return float(self.evaluate("document.getElementById('stage').style.getPropertyValue(arguments[0])", name))

    # --- what the page shows

    def test_it_opens_with_before_and_after(self):
        self.load(DESKTOP)
        self.assertEqual((self.shown("left"), self.shown("right")), (NAMES[0], NAMES[1]))
        self.assertEqual(self.split(), 50)
        self.assertEqual([option.text.split(" ", 1)[1] for option in Select(self.by_id("left")).options], NAMES)
        handle = self.by_id("handle")
        self.assertEqual(handle.get_attribute("role"), "slider")
        self.assertIn(NAMES[1], handle.get_attribute("aria-valuetext"))
        self.assertTrue(self.evaluate("[...document.images].every((i) => i.complete && i.naturalWidth > 0)"))
        self.shoot("desktop-light")

    def test_the_divider_parts_the_pictures_where_it_stands(self):
        self.load(DESKTOP)
        self.point("mouse", [self.at(0.5), self.at(0.25)])
        clip = self.evaluate("getComputedStyle(document.querySelector('figure.left')).clipPath")
        self.assertRegex(clip, r"inset\(0px 75")
        visible = [figure.get_attribute("data-name") for figure in
                   self.browser.find_elements(By.CSS_SELECTOR, "figure.picture") if figure.is_displayed()]
        self.assertEqual(visible, NAMES[:2])

    def test_mouse_drags_the_handle_and_clicks_move_it(self):
        self.load(DESKTOP)
        self.point("mouse", [self.at(0.5), self.at(0.6), self.at(0.75)])
        self.assertAlmostEqual(self.split(), 75, delta=1)
        self.point("mouse", [self.at(0.2, 0.3)])
        self.assertAlmostEqual(self.split(), 20, delta=1)
        self.point("mouse", [self.at(0.2), self.at(1.1)])
        self.assertEqual(self.split(), 100)

    def test_touch_drags_the_handle_and_the_picture(self):
        self.load(PHONE, touch=True)
        self.point("touch", [self.at(0.5), self.at(0.6), self.at(0.8)])
        self.assertAlmostEqual(self.split(), 80, delta=2)
        self.point("touch", [self.at(0.3, 0.3), self.at(0.4, 0.3), self.at(0.6, 0.3)])
        self.assertAlmostEqual(self.split(), 60, delta=2)

    def test_a_finger_that_goes_up_scrolls_the_page(self):
        self.load(PHONE, touch=True)
        x, y = self.at(0.2, 0.9)
        before = self.evaluate("scrollY")
        self.point("touch", [(x, y), (x, y - 60), (x, y - 160), (x, y - 240)])
        time.sleep(0.3)
        self.assertGreater(self.evaluate("scrollY"), before + 50)
        self.assertEqual(self.split(), 50)

    def test_pinch_zooms_and_a_finger_then_pans(self):
        self.load(PHONE, touch=True)
        self.point("touch", *([self.at(0.5 + side * share) for share in (0.1, 0.2, 0.35)] for side in (-1, 1)))
        self.assertGreater(self.zoom(), 2)
        before = self.style("--x")
        self.point("touch", [self.at(0.3, 0.3), self.at(0.35, 0.3), self.at(0.5, 0.35)])
        self.assertNotEqual(self.style("--x"), before)
        self.assertEqual(self.split(), 50)

    def test_double_tap_shows_pixels(self):
        self.load(PHONE, touch=True)
        place = self.at(0.25, 0.25)
        self.point("touch", [place], times=2)
        self.assertEqual(self.zoom(), 4)
        self.assertEqual(self.evaluate("getComputedStyle(document.querySelector('.live img')).imageRendering"), "pixelated")

    def test_keys_move_the_divider(self):
        self.load(DESKTOP)
        handle = self.by_id("handle")
        for keys, expected in [(Keys.ARROW_RIGHT * 3, 53), (Keys.ARROW_LEFT, 52), (Keys.PAGE_UP, 62), (Keys.PAGE_DOWN * 2, 42),
                               (Keys.HOME, 0), (Keys.ARROW_LEFT, 0), (Keys.END, 100), (Keys.ARROW_DOWN, 99)]:
            handle.send_keys(keys)
            self.assertEqual(self.split(), expected)

    def test_tab_reaches_the_handle(self):
        self.load(DESKTOP)
        for _ in range(12):
            ActionChains(self.browser).send_keys(Keys.TAB).perform()
            if self.browser.switch_to.active_element.get_attribute("id") == "handle":
                return
        self.fail("Tab doesn't reach the handle")

    def press(self, *keys):
        ActionChains(self.browser).send_keys(*keys).perform()

    def test_digits_choose_pictures(self):
        self.load(DESKTOP)
        self.press("3")
        self.assertEqual((self.shown("left"), self.shown("right")), (NAMES[0], NAMES[2]))
        ActionChains(self.browser).key_down(Keys.SHIFT).send_keys("4").key_up(Keys.SHIFT).perform()
        self.assertEqual((self.shown("left"), self.shown("right")), (NAMES[3], NAMES[2]))
        self.press("x")
        self.assertEqual((self.shown("left"), self.shown("right")), (NAMES[2], NAMES[3]))
        self.press("9")
        self.assertEqual(self.shown("right"), NAMES[3])

    def test_selects_choose_pictures(self):
        self.load(PHONE, touch=True)
        Select(self.by_id("right")).select_by_index(3)
        Select(self.by_id("left")).select_by_index(2)
        self.assertEqual((self.shown("left"), self.shown("right")), (NAMES[2], NAMES[3]))

    def test_the_same_picture_on_both_sides_is_whole(self):
        self.load(DESKTOP)
        self.press("1")
        self.assertEqual(self.evaluate("getComputedStyle(document.querySelector('figure.left')).clipPath"), "none")

    def test_error_maps_come_and_go(self):
        self.load(DESKTOP)
        legend = self.browser.find_element(By.CLASS_NAME, "legend")
        error = self.browser.find_element(By.CSS_SELECTOR, "figure.left img.error")
        self.assertFalse(legend.is_displayed() or error.is_displayed())
        self.press("e")
        self.assertTrue(legend.is_displayed() and error.is_displayed())
        self.assertIn("no unit", legend.text)
        self.assertEqual(self.shown("left"), "error: " + NAMES[0])
        self.shoot("desktop-errors")
        self.by_id("errors").click()
        self.assertFalse(error.is_displayed())

    def test_wheel_and_keys_zoom_about_the_place(self):
        self.load(DESKTOP)
        stage = self.by_id("stage")
        self.point("mouse", [self.at(0.5)])
        self.wheel(stage, -200)
        wheel = self.zoom()
        self.assertGreater(wheel, 1.5)
        self.press("+")
        self.assertAlmostEqual(self.zoom(), 2 * wheel, delta=0.01)
        x, y = self.style("--x"), self.style("--y")
        self.assertAlmostEqual(x, (1 - self.zoom()) / 2, delta=0.02)
        self.assertAlmostEqual(y, (1 - self.zoom()) / 2, delta=0.02)
        self.shoot("desktop-zoomed")
        self.press("0")
        self.assertEqual(self.zoom(), 1)
        for _ in range(20):
            self.press("+")
        self.assertLessEqual(self.evaluate("document.getElementById('stage').clientWidth") * self.zoom() / 480, 32.01)

    def test_the_wheel_scrolls_the_page_until_the_picture_was_clicked(self):
        self.load((1280, 500))
        self.wheel(self.by_id("stage"), 120)
        self.assertEqual(self.zoom(), 1)
        self.assertGreater(self.evaluate("scrollY"), 0)

    def test_a_drag_pans_the_enlarged_picture(self):
        self.load(DESKTOP)
        self.by_id("in").click()
        self.assertEqual(self.zoom(), 2)
        self.point("mouse", [self.at(0.2), self.at(0.3)])
        self.assertEqual(self.split(), 50)
        self.assertAlmostEqual(self.style("--x"), -0.4,
                               delta=0.01)
        self.point("mouse", [self.at(0.2), self.at(0.99)])
        self.assertLessEqual(self.style("--x"), 0)

    def test_the_table_marks_the_best(self):
        self.load(DESKTOP)
        rows = self.browser.find_elements(By.CSS_SELECTOR, "tbody tr")
        self.assertEqual([row.find_element(By.TAG_NAME, "th").text for row in rows], NAMES)
        self.assertEqual([len(row.find_elements(By.TAG_NAME, "strong")) for row in rows], [0, 4, 0, 0])

    def test_curves_tell_their_values(self):
        self.load(DESKTOP)
        panels = self.browser.find_elements(By.CSS_SELECTOR, ".panels figure")
        self.assertEqual(len(panels), 3)
        point = panels[0].find_element(By.CLASS_NAME, "point")
        self.box(point)
        self.shoot("desktop-curves")
        ActionChains(self.browser).move_to_element(point).perform()
        self.assertRegex(panels[0].find_element(By.TAG_NAME, "output").text, r"samples a pixel: [0-9.]+ s, mrse")

    def test_nothing_is_wider_than_the_window(self):
        for size, touch in [(DESKTOP, False), (PHONE, True), ((320, 640), True)]:
            self.load(size, touch=touch)
            self.assertLessEqual(self.evaluate("document.documentElement.scrollWidth"), size[0])

    def test_targets_are_large_enough_for_fingers(self):
        self.load(PHONE, touch=True)
        for element in self.browser.find_elements(By.CSS_SELECTOR, ".tools button, .tools select, .handle"):
            if element.is_displayed():
                _, _, width, height = self.box(element)
                self.assertGreaterEqual(min(width, height), 40)

    def test_text_has_contrast_in_both_schemes(self):
        for scheme in ["light", "dark"]:
            self.load(DESKTOP, scheme)
            for name in ["--ink", "--faint", "--accent"]:
                ratio = self.evaluate(CONTRAST, name)
                self.assertGreaterEqual(ratio, 4.5, f"{name}, {scheme}")

    def test_without_javascript_pictures_and_table_are_there(self):
        self.load(DESKTOP, script=False)
        self.shoot("desktop-no-script")
        self.browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})
        for image in self.browser.find_elements(By.CSS_SELECTOR, ".pictures img"):
            self.assertTrue(image.is_displayed())
        self.assertFalse(self.browser.find_elements(By.CLASS_NAME, "tools"))
        self.assertTrue(self.browser.find_element(By.TAG_NAME, "table").is_displayed())

    def test_it_prints(self):
        self.load(DESKTOP)
        pdf = self.browser.execute_cdp_cmd("Page.printToPDF", {"printBackground": False})["data"]
        self.assertGreater(len(pdf), 10000)
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        self.assertEqual(len([figure for figure in self.browser.find_elements(By.CSS_SELECTOR, "figure.picture")
                              if figure.is_displayed()]), len(NAMES))
        self.assertFalse(self.browser.find_element(By.CLASS_NAME, "tools").is_displayed())
        self.shoot("print")
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})

    def test_screenshots_of_all_sizes(self):
        for name, size, scheme, touch in [("desktop-dark", DESKTOP, "dark", False), ("phone-light", PHONE, "light", True),
                                          ("phone-dark", PHONE, "dark", True)]:
            self.load(size, scheme, touch)
            self.shoot(name)
            self.evaluate("document.querySelector('table').scrollIntoView()")
            self.shoot(name + "-table")
            self.evaluate("scrollTo(0, document.body.scrollHeight)")
            self.shoot(name + "-end")
        self.assertGreaterEqual(len(list(SHOTS.glob("*.png"))), 9)


# Contrast of a colour of the page against its ground (WCAG 2.2, relative luminance).
CONTRAST = """((name) => {
  const light = (variable) => {
    const hex = getComputedStyle(document.documentElement).getPropertyValue(variable).trim();
    return [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255)
      .map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4))
      .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  };
  const [bright, dark] = [light(name), light("--ground")].sort((p, q) => q - p);
  return (bright + 0.05) / (dark + 0.05);
})(arguments[0])"""

if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
