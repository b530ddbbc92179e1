"""A headless Chromium, driven over its own pipe: no port, no other package.

    with Browser() as browser:
        page = browser.open(path, width=390, height=800)
        page.evaluate("document.title")
"""

import base64
import contextlib
import json
import os
import select
import shutil
import subprocess
import tempfile
import time

PROGRAM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--hide-scrollbars",
         "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage",
         "--remote-debugging-pipe")  # fmt: skip
ANSWER_S = 120


class Browser:
    """Chromium as a child with an empty profile."""

    def __enter__(self):
        assert PROGRAM, "no Chromium here; tools/setup browser installs it"
        self.profile = tempfile.mkdtemp(prefix="talus-browser-")
        inbound, self.to = os.pipe()
        self.back, outbound = os.pipe()
        # the browser reads from descriptor 3 and writes to 4
        script = f'exec "$0" "$@" 3<&{inbound} 4>&{outbound}'
        command = ["bash", "-c", script, PROGRAM, *FLAGS, f"--user-data-dir={self.profile}", "about:blank"]
        self.child = subprocess.Popen(command, pass_fds=(inbound, outbound), stdin=subprocess.DEVNULL,
                                      stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip
        os.close(inbound)
        os.close(outbound)
        self.number, self.rest, self.events = 0, b"", []
        return self

    def __exit__(self, *_):
        with contextlib.suppress(OSError, AssertionError):
            self.call("Browser.close")
        try:
            self.child.wait(20)
        except subprocess.TimeoutExpired:
            self.child.kill()
            self.child.wait()
        os.close(self.to)
        os.close(self.back)
        shutil.rmtree(self.profile, ignore_errors=True)

    def receive(self, until):
        """The next message before the time `until`."""
        while b"\0" not in self.rest:
            ready, _, _ = select.select([self.back], [], [], max(until - time.monotonic(), 0))
            assert ready, "the browser does not answer"
            more = os.read(self.back, 1 << 20)
            assert more, "the browser has ended"
            self.rest += more
        message, self.rest = self.rest.split(b"\0", 1)
        return json.loads(message)

    def call(self, method, session=None, **parameters):
        """The result of one command; events on the way are kept."""
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        until = time.monotonic() + ANSWER_S
        while True:
            answer = self.receive(until)
            if answer.get("id") == self.number:
                assert "error" not in answer, f"{method}: {answer['error']}"
                return answer["result"]
            self.events.append(answer)

    def wait_for(self, session, method):
        """Until an event of a session has come."""
        until = time.monotonic() + ANSWER_S
        while not any(e.get("method") == method and e.get("sessionId") == session for e in self.events):
            self.events.append(self.receive(until))

    def open(self, path, width, height, scale=1, mobile=False):
        """A page of a file, loaded."""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable", session)
        self.call("Emulation.setDeviceMetricsOverride", session, width=width, height=height, deviceScaleFactor=scale,
                  mobile=mobile)  # fmt: skip
        self.events.clear()
        self.call("Page.navigate", session, url=f"file://{path}")
        self.wait_for(session, "Page.loadEventFired")
        return Page(self, session)


class Page:
    """One loaded page."""

    def __init__(self, browser, session):
        self.browser, self.session = browser, session

    def call(self, method, **parameters):
        return self.browser.call(method, self.session, **parameters)

    def evaluate(self, expression):
        """The value of a JavaScript expression."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def of(self, method):
        """What has been reported by one kind of event."""
        return [e["params"] for e in self.browser.events if e.get("method") == method and e.get("sessionId") == self.session]

    def complaints(self):
        """Errors and warnings of the console, exceptions, and what the browser itself logged."""
        return (self.of("Runtime.exceptionThrown") + self.of("Log.entryAdded")
                + [e for e in self.of("Runtime.consoleAPICalled") if e["type"] in ("error", "warning", "assert")])  # fmt: skip

    def requests(self):
        """Addresses that the page asked for."""
        return [e["request"]["url"] for e in self.of("Network.requestWillBeSent")]

    def picture(self, height=None):
        """A PNG of the page from its top; `height` pixels of it, or all."""
        size = self.call("Page.getLayoutMetrics")["cssContentSize"]
        clip = {"x": 0, "y": 0, "width": size["width"], "height": height or size["height"], "scale": 1}
        answer = self.call("Page.captureScreenshot", format="png", clip=clip, captureBeyondViewport=True)
        return base64.b64decode(answer["data"])

    def paper(self):
        """A PDF, as printed."""
        return base64.b64decode(self.call("Page.printToPDF", printBackground=True)["data"])
