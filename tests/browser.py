"""browser.py - headless Chromium, driven by the W3C WebDriver protocol that chromedriver speaks.

Only what the page's test needs. A call that the driver refuses raises farm.Failure with its reason.
https://www.w3.org/TR/webdriver2/. SPDX-License-Identifier: MIT
"""

import base64
import os
import re
import shutil

import farm

TAB, ENTER, ESCAPE = "\ue004", "\ue007", "\ue00c"

FLAGS = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync",
         "--window-size=1200,900"]


def missing():
    """What is not installed, as text; None when all is there."""
    names = [name for name in ("chromium", "chromedriver") if not shutil.which(name)]
    return f"{' and '.join(names)} not installed" if names else None


class Browser:
    def __init__(self, f):
        """Driver and browser belong to the farm, which stops them. Their files are in its directory."""
        home = os.path.join(f.dir, "browser")
        os.mkdir(home)
        env = {**os.environ, "HOME": home, "TMPDIR": home, "XDG_CONFIG_HOME": home, "XDG_CACHE_HOME": home}
        self.driver = f.start("chromedriver", [shutil.which("chromedriver"), "--port=0"], env)
        port = f.wait_for("chromedriver to start",
                          lambda: re.search(r"started successfully on port (\d+)", self.driver.log()))[1]
        self.session = f"http://127.0.0.1:{port}"
        options = {"binary": shutil.which("chromium"),
                   "args": FLAGS + [f"--user-data-dir={os.path.join(home, 'profile')}"]}
        session = self._call("POST", "/session", {"capabilities": {"alwaysMatch": {
            "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}}})
        self.session += f"/session/{session['sessionId']}"

    def _call(self, method, path, body=None):
        reply = farm.request(method, self.session + path, {} if body is None and method == "POST" else body, limit=60)
        value = reply.json()["value"]
        if reply.status != 200:
            raise farm.Failure(f"chromedriver: {path}: {value['error']}: {value['message'].splitlines()[0]}")
        return value

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
        self.driver.kill()  # it knows no other end
