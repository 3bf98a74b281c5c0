"""PlatformIO: builds libvarsac.a with cargo for the board at hand and links it."""

import os
import subprocess

Import("env")  # noqa: F821 - PlatformIO puts it there

# The core of the board decides the target; a board with another core needs a line here.
TARGETS = {
    "cortex-m3": "thumbv7m-none-eabi",
    "cortex-m4": "thumbv7em-none-eabihf",
    "cortex-m7": "thumbv7em-none-eabihf",
    "cortex-m33": "thumbv8m.main-none-eabihf",
    "cortex-m55": "thumbv8m.main-none-eabihf",
}

cpu = env.BoardConfig().get("build.cpu", "")  # noqa: F821
if cpu not in TARGETS:
    raise SystemExit(f"varsac: no target for the core '{cpu}'; add it to platformio/build_varsac.py")
target = TARGETS[cpu]
here = os.path.dirname(os.getcwd()) if os.path.basename(os.getcwd()) == "platformio" else os.getcwd()
folder = os.path.join(env.subst("$BUILD_DIR"), "varsac")  # noqa: F821
subprocess.run(
    ["cargo", "build", "--package", "varsac-capi", "--profile", "firmware", "--target", target, "--target-dir", folder],
    cwd=here,
    check=True,
)
env.Append(LIBPATH=[os.path.join(folder, target, "firmware")], LIBS=["varsac"])  # noqa: F821
