"""browser.py - headless Chromium, driven by the W3C WebDriver protocol that chromedriver speaks.

Only what the page's test needs. A call that the driver refuses raises Failure with its reason.
https://www.w3.org/TR/webdriver2/. SPDX-License-Identifier: MIT
"""

import base64
import json
import os
import re
import shutil
import urllib.error
import urllib.request

from farm import OPENER, Failure

TAB, ENTER, ESCAPE = "\ue004", "\ue007", "\ue00c"

FLAGS = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync",
         "--window-size=1200,900"]


def missing():
    """What is not installed, as text; None when all is there."""
    names = [name for name in ("chromium", "chromedriver") if not shutil.which(name)]
    return f"{' and '.join(names)} not installed" if names else None


class Browser:
    def __init__(self, farm):
        """Driver and browser belong to the farm, which stops them. Their files are in its folder."""
        home = farm.folder / "browser"
        home.mkdir()
        env = {**os.environ, "HOME": str(home), "TMPDIR": str(home), "XDG_CONFIG_HOME": str(home),
               "XDG_CACHE_HOME": str(home)}
        driver = farm.spawn("chromedriver", shutil.which("chromedriver"), "--port=0", env=env)
        ready = re.compile(r"started successfully on port (\d+)")
        farm.wait_for(lambda: ready.search(driver.log.read_text()), 30, "chromedriver starts")
        self.session = f"http://127.0.0.1:{ready.search(driver.log.read_text())[1]}"
        options = {"binary": shutil.which("chromium"), "args": FLAGS + [f"--user-data-dir={home / 'profile'}"]}
        session = self._call("POST", "/session", {"capabilities": {"alwaysMatch": {
            "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}}})
        self.session += f"/session/{session['sessionId']}"

    def _call(self, method, path, body=None):
        request = urllib.request.Request(self.session + path, method=method,
                                         data=None if method == "DELETE" else json.dumps(body).encode(),
                                         headers={"Content-Type": "application/json"})
        try:
            with OPENER.open(request, timeout=60) as reply:
                return json.load(reply)["value"]
        except urllib.error.HTTPError as error:
            with error:
                why = json.load(error)["value"]
            raise Failure(f"chromedriver: {path}: {why['error']}: {why['message'].splitlines()[0]}") from None

    def open(self, url):
        self._call("POST", "/url", {"url": url})

    def run(self, script, *args):
        """The body of a function; its return value."""
        return self._call("POST", "/execute/sync", {"script": script, "args": list(args)})

    def text(self, selector):
        """The text that is shown by the first match; None without one."""
        return self.run("return document.querySelector(arguments[0])?.innerText ?? null", selector)

    def press(self, key):
        """A key of the keyboard, down and up, wherever the focus is."""
        keys = [{"type": "keyDown", "value": key}, {"type": "keyUp", "value": key}]
        self._call("POST", "/actions", {"actions": [{"type": "key", "id": "keyboard", "actions": keys}]})

    def tab_to(self, text, limit=40):
        """Presses Tab until the focus is on what reads `text`, as a person would."""
        for _ in range(limit):
            self.press(TAB)
            if self.focus() == text:
                return True
        return False

    def focus(self):
        return self.run("return document.activeElement?.innerText.trim()")

    def devtools(self, command, **params):
        return self._call("POST", "/goog/cdp/execute", {"cmd": command, "params": params})

    def size(self, width, height, phone=False):
        self.devtools("Emulation.setDeviceMetricsOverride", width=width, height=height,
                      deviceScaleFactor=2 if phone else 1, mobile=phone)

    def media(self, **features):
        """media(prefers_color_scheme="dark")"""
        self.devtools("Emulation.setEmulatedMedia", features=[
            {"name": name.replace("_", "-"), "value": value} for name, value in features.items()])

    def screenshot(self, path):
        shot = self.devtools("Page.captureScreenshot", format="png", captureBeyondViewport=True)
        with open(path, "wb") as file:
            file.write(base64.b64decode(shot["data"]))

    def console(self):
        """What the console said since the last call: warnings and errors."""
        return [entry["message"] for entry in self._call("POST", "/se/log", {"type": "browser"})
                if entry["level"] in ("SEVERE", "WARNING")]

    def close(self):
        self._call("DELETE", "")
