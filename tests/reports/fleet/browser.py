"""Runs a page in headless Chromium: a script at its end clicks about and leaves what it found in the page."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import shutil
import subprocess
from html import unescape
from pathlib import Path
from typing import Any

import pytest

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
needs_browser = pytest.mark.skipif(BROWSER is None, reason="no Chromium on this machine")

FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--enable-logging=stderr", "--v=0", "--virtual-time-budget=8000",
)  # fmt: skip

PROBE = """
const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const settle = () => wait(50);
const all = (selector, under = document) => [...under.querySelectorAll(selector)];
const cells = (column) => all("#drives-table tbody tr").map((row) => row.children[column].firstChild.firstChild.textContent);
const set = async (id, value) => { const f = document.getElementById(id); f.value = value; f.dispatchEvent(new Event(f.tagName === "SELECT" ? "change" : "input")); await wait(200); };
const rejections = [];
addEventListener("error", (event) => rejections.push(String(event.message)));
addEventListener("unhandledrejection", (event) => rejections.push(String(event.reason)));
(async () => {
  let found = null, wrong = null;
  try { found = await (async () => { %s })(); } catch (error) { wrong = String(error.stack || error); }
  const out = document.createElement("pre");
  out.id = "probe-found";
  out.textContent = JSON.stringify({ found, wrong, rejections });
  document.body.append(out);
})();
"""


def run(html: str, folder: Path, script: str, width: int = 1400) -> tuple[Any, list[str]]:
    """What `script` (the body of an async function) returns, and every line of the browser's console.

    The copy's policy is given the probe's hash besides the page's own, so that the page runs under its real policy.
    """
    assert BROWSER is not None
    probe = PROBE % script
    digest = base64.b64encode(hashlib.sha256(probe.encode()).digest()).decode()
    html = html.replace("script-src '", f"script-src 'sha256-{digest}' '", 1)
    html = html.replace("</body>", f"<script>{probe}</script></body>")
    page = folder / "fleet.html"
    page.write_text(html, encoding="utf-8")
    profile = folder / "profile"
    done = subprocess.run(
        [BROWSER, *FLAGS, f"--window-size={width},1000", f"--user-data-dir={profile}", "--dump-dom", page.as_uri()],
        capture_output=True, timeout=120, check=True,
    )  # fmt: skip
    console = [line for line in done.stderr.decode("utf-8", "replace").splitlines() if "CONSOLE" in line]
    left = re.search(r'<pre id="probe-found">(.*?)</pre>', done.stdout.decode("utf-8", "replace"), re.DOTALL)
    assert left is not None, f"the page's script did not end; console: {console}"
    told = json.loads(unescape(left.group(1)))
    assert told["wrong"] is None, told["wrong"]
    assert told["rejections"] == []
    return told["found"], console
