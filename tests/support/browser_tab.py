"""A Chromium without a window, and a page that is open in it.  Needs Playwright and matplotlib."""

import io
import shutil
from contextlib import contextmanager

import numpy as np
from matplotlib.image import imread
from playwright.sync_api import sync_playwright

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
ARGUMENTS = [
    *("--headless", "--no-sandbox", "--no-first-run", "--disable-sync", "--disable-quic"),
    *("--disable-background-networking", "--disable-component-update"),
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),  # WebGL without a GPU
]


@contextmanager
def chromium():
    """The browser, for as long as it is needed."""
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield started
        started.close()


class Tab:
    """A page that is open, what it asked the network for, and what went wrong in it."""

    def __init__(self, browser, file, **options):
        self.context = browser.new_context(**options)
        self.page = self.context.new_page()
        self.file = file
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.on("console", lambda message: self.complaints.append(message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))

    def open(self):
        """Begin anew."""
        self.requests, self.complaints = [], []
        self.page.emulate_media(color_scheme="light")
        self.page.mouse.move(2, 2)
        self.page.goto(self.file.as_uri())
        self.restore_delaunay()
        return self

    def restore_delaunay(self):
        """Wait until what has changed is drawn."""
        self.page.evaluate("new Promise((f) => requestAnimationFrame(() => requestAnimationFrame(f)))")

    def pixels(self):
        """The canvas with what is behind it, (h, w, 3), 0 to 1."""
        self.restore_delaunay()
        return imread(io.BytesIO(self.page.locator("#canvas").screenshot()))[:, :, :3]

    def shape(self):
        """Where the surface is on the canvas, between its buttons."""
        everything = self.pixels()[:, 70:-70]
        return np.abs(everything - everything[5, 5]).max(axis=2) > 0.25

    def text(self, selector):
        return self.page.locator(selector).inner_text()
