"""Program that simulates hair of a .blend file as the button Simulate of the extension does.

Blender is under the GNU GPL: this file is run as a program, and nothing imports it. `hairpipe blender FILE --simulate`
runs it with a job on standard input:

    file       path of the .blend file; no script in it is run
    hair       name of the hair object
    extension  folder with the extension as the package `hairpipe_extension`
    program    path of hairpipe
    output     .blend file to save with the result; absent: no .blend file is saved
"""

import json
import os
import sys

import bpy


def main() -> None:
    job = json.load(sys.stdin)
    os.environ["HAIRPIPE"] = job["program"]
    sys.path.insert(0, job["extension"])
    import hairpipe_extension  # pyright: ignore[reportMissingImports]

    bpy.ops.wm.read_factory_settings(use_empty=True)
    hairpipe_extension.register()
    bpy.ops.wm.open_mainfile(filepath=job["file"], load_ui=False, use_scripts=False)
    try:
        done = bpy.ops.hairpipe.simulate(name=job["hair"])
    except RuntimeError as fault:
        sys.exit(str(fault).removeprefix("Error: ").strip())
    finally:
        hairpipe_extension.stop()
    if "FINISHED" not in done:
        sys.exit("hair is not simulated")
    if "output" in job:
        bpy.ops.wm.save_as_mainfile(filepath=job["output"])
    sys.stdout.flush()
    os._exit(0)  # the module of Blender 4.2 crashes at its end where a class with a function is registered
