"""Runs inside Blender: imports exported animations with the add-on, and compares what Blender shows with the
archive. Arguments after `--` are the add-on, the archive, the frames per second, and .glb files. Without
files, the add-on exports the archive itself with the program named by the environment variable SLEIGHT.

Goal: Blender shows bodies at the archive's positions and orientations, at ten times of each animation.
Method: read the segments of the motions with h5py, and evaluate their closed form here. Integrate angular
motion by small steps.
"""

import importlib.util
import math
import os
import sys

import bpy
import h5py
import mathutils

PLACE_M = 1e-4           # as docs/EXPORT.md says
TURN_RAD = math.radians(0.2)
STEPS = 2000             # of a turn whose axis turns too: the error is below 1e-6 rad


def load(path):
    spec = importlib.util.spec_from_file_location("sleight_import", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def rows_of(archive, identifier):
    """The segments of an animation as a list of dicts."""
    chain, draw = identifier.split(".")
    group = archive["finds" if chain == "find" else "animations"]
    if chain == "find":
        nth = int(draw)
    else:
        nth = next(i for i in range(len(group["chain"]))
                   if (group["chain"][i], group["draw"][i]) == (int(chain), int(draw)))
    first, count = group["segment_start"][nth], group["segment_count"][nth]
    names = ["body", "mode", "start_s", "position_m", "velocity_mps", "acceleration_mps2",
             "orientation", "angular_velocity_radps", "angular_acceleration_radps2"]
    columns = {name: group[name][first:first + count] for name in names}
    return [{name: columns[name][i] for name in names} for i in range(count)]


def pose_at(segments, time_s):
    """Centre and orientation of a body, or None before it enters."""
    begun = [segment for segment in segments if segment["start_s"] <= time_s]
    if not begun:
        return None
    segment = begun[-1]
    s = time_s - segment["start_s"]
    centre = (segment["position_m"] + segment["velocity_mps"] * s
              + segment["acceleration_mps2"] * s * s / 2)
    turn = mathutils.Quaternion(segment["orientation"])
    if segment["mode"] != 3:
        speed, change = segment["angular_velocity_radps"], segment["angular_acceleration_radps2"]
        for step in range(STEPS):
            way = (speed + change * ((step + 0.5) * s / STEPS)) * (s / STEPS)
            angle = math.sqrt(sum(way * way))
            if angle > 0:
                turn = mathutils.Quaternion(mathutils.Vector(way), angle) @ turn
    return mathutils.Vector(centre), turn.normalized()


def compare(archive, collection, fps):
    """Returns the greatest differences of an animation, in metres and radians, and the number of
    comparisons."""
    rows = rows_of(archive, collection["id"])
    names = [name.decode() if isinstance(name, bytes) else str(name)
             for name in feature_names(archive)]
    objects = {item.name.rsplit(".", 1)[0] if item.name not in names else item.name: item
               for item in collection.objects}
    end_s = collection["duration_s"]
    worst_m = worst_rad = 0.0
    compared = 0
    for tenth in range(10):
        frame = end_s * (tenth + 0.5) / 10 * fps
        # Blender's frames have single precision: compute the time that it shows.
        whole = math.floor(frame)
        bpy.context.scene.frame_set(whole, subframe=frame - whole)
        time_s = bpy.context.scene.frame_current_final / fps
        for body in sorted({int(row["body"]) for row in rows}):
            item = objects[names[body]]
            true = pose_at([row for row in rows if row["body"] == body], time_s)
            shown = item.matrix_world
            if true is None:
                assert max(shown.to_scale()) == 0, f"{item.name} is there before it enters"
                continue
            assert abs(min(shown.to_scale()) - 1) < 1e-4, f"{item.name} is not there"
            worst_m = max(worst_m, (shown.to_translation() - true[0]).length)
            turn = shown.to_quaternion().rotation_difference(true[1])
            worst_rad = max(worst_rad, 2 * math.asin(min(1, mathutils.Vector(turn[1:]).length)))
            compared += 1
    return worst_m, worst_rad, compared


def feature_names(archive):
    """netCDF-4 stores texts as rows of single characters."""
    rows = archive["scene/feature_name"][()]
    if rows.ndim == 1:
        return list(rows)
    return [b"".join(row).rstrip(b"\0").decode() for row in rows]


def main():
    addon_path, archive_path, fps, *files = sys.argv[sys.argv.index("--") + 1:]
    fps = int(fps)
    addon = load(addon_path)
    addon.register()
    for item in list(bpy.data.objects):  # the start-up file's cube
        bpy.data.objects.remove(item)
    if files:
        folder = os.path.dirname(files[0])
        result = bpy.ops.import_scene.sleight(
            directory=folder, files=[{"name": os.path.basename(file)} for file in files], fps=fps)
    else:
        result = bpy.ops.import_scene.sleight(filepath=archive_path, fps=fps,
                                              program=os.environ["SLEIGHT"])
    assert result == {"FINISHED"}, result
    scene = bpy.context.scene
    made = addon.ours(scene)
    assert not files or len(made) == len(files), (len(made), files)
    assert len({one.name for one in made}) == len(made)
    assert scene.render.fps == fps and scene.frame_start == 0
    longest_s = max(one["duration_s"] for one in made)
    assert scene.frame_end == max(1, math.ceil(longest_s * fps - 1e-4)), scene.frame_end
    with h5py.File(archive_path) as archive:
        request = archive["request"][()].decode().rstrip("\0")
        worst = [0.0, 0.0]
        compared = 0
        for collection in made:
            assert collection.name == collection["id"], collection.name
            assert collection["request"] == request
            assert math.isfinite(collection["log_prior"])
            materials = {slot.material.name for item in collection.objects
                         for slot in item.material_slots}
            assert materials, "bodies have no material"
            off_m, off_rad, count = compare(archive, collection, fps)
            worst = [max(worst[0], off_m), max(worst[1], off_rad)]
            compared += count
    assert compared > 0
    # A second import of the same files adds to the first, under other names.
    if files:
        again = addon.import_files(files[:1], fps)
        assert again[0].name != made[0].name and again[0]["id"] == made[0]["id"]
        assert len(again[0].objects) == len(made[0].objects)
    print(f"in Blender {bpy.app.version_string}: {len(made)} animations, {compared} poses, off by at "
          f"most {1e3 * worst[0]:.4f} mm and {math.degrees(worst[1]):.4f} degrees")
    assert worst[0] <= PLACE_M, worst
    assert worst[1] <= TURN_RAD, worst


try:
    main()
except BaseException:
    import traceback
    traceback.print_exc()
    sys.stdout.flush()
    os._exit(1)  # Blender itself ends with 0 whatever its script does
