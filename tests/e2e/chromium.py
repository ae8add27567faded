"""Where the browser is, and what it is started with; the benchmarks use the same."""

EXECUTABLE = "/usr/bin/chromium"
FLAGS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-extensions",
    "--no-first-run",
    "--disable-domain-reliability",
    "--disable-dev-shm-usage",
    "--disable-renderer-backgrounding",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
]

# Tests alone: the page is put together without the program that stands in for a GPU, which takes
# eight times as long for it.  What WebGL draws is the same.
COMPOSED = "--disable-gpu-compositing"

# Pictures are prepared whole, and nothing is drawn: this machine's GPU is a program.
UNDRAWN = """
for (const draw of [
  'clear', 'drawArrays', 'drawElements', 'drawArraysInstanced', 'drawElementsInstanced',
])
  WebGL2RenderingContext.prototype[draw] = () => {};
"""

# Somebody who has left the tour of first steps, which comes unasked to who has not.
TOUR_LEFT = "if (location.origin !== 'null') localStorage.setItem('pointbrush.tour', 'left');"
