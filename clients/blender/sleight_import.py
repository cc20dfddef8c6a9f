"""Blender add-on: imports animations that Sleight exported, or exports and imports them itself.

Install this file by Edit > Preferences > Add-ons > Install, and tick "Sleight animations". Then
File > Import > Sleight animations accepts any number of .glb files, or .h5 archives if the program
`sleight` is installed. Each file becomes a collection named after its animation ("c0.250"), with the
file's metadata (request, run_id, log_prior, ...) as custom properties. The importer sets the frame
rate. Frame 0 is an animation's beginning, and the scene's range ends with the longest animation.

Blender has the archive's coordinates: metres, z up. docs/EXPORT.md describes the files.
"""

import json
import math
import pathlib
import shutil
import struct
import subprocess
import tempfile

import bpy
from bpy.props import BoolProperty, CollectionProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

bl_info = {
    "name": "Sleight animations",
    "description": "Import directed animations (.glb, or .h5 by the program sleight)",
    "author": "The Sleight authors",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "File > Import > Sleight animations",
    "category": "Import-Export",
}

END_S = "sleight_end_s"  # end of a collection's motion; also marks imported collections
FPS = "sleight_fps"      # frame rate at which a scene's animations were imported
SECONDS_MAX = 3600       # maximum time of an export
INT_MAX = 2**31 - 1      # Blender's properties can't hold larger integers


class ImportFailed(Exception):
    """An error with advice for the person who imports."""


def document_of(path):
    """Returns the JSON of a .glb, read here because Blender's importer drops most extras."""
    with open(path, "rb") as file:
        head = file.read(20)
        if len(head) < 20 or head[:4] != b"glTF":
            raise ImportFailed(f"{path}: not a .glb file")
        version, _, length, kind = struct.unpack("<IIII", head[4:])
        text = file.read(length)
    if version != 2 or kind != 0x4E4F534A or len(text) != length:
        raise ImportFailed(f"{path}: this .glb file is truncated, or its version is not 2")
    try:
        return json.loads(text)
    except ValueError as error:
        raise ImportFailed(f"{path}: its JSON is damaged: {error}") from error


def end_s_of(document):
    """Returns the time of the last key of any clip."""
    times = {sampler["input"] for animation in document.get("animations", [])
             for sampler in animation["samplers"]}
    return max((document["accessors"][time]["max"][0] for time in times), default=0.0)


def set_properties(holder, extras):
    for key, value in extras.items():
        if value is None or isinstance(value, dict):
            continue
        if isinstance(value, int) and not isinstance(value, bool) and abs(value) > INT_MAX:
            value = str(value)
        if isinstance(value, list):
            value = [math.nan if one is None else one for one in value]
            if not value:
                continue
        holder[key[:63]] = value  # maximum length of a name in Blender


def load_glb(path):
    """Runs Blender's own importer and returns the new objects."""
    try:
        import numpy
    except ImportError as error:
        raise ImportFailed("Blender's glTF importer needs numpy; on Debian: apt-get install "
                           "python3-numpy") from error
    # Blender 3.4's importer uses a name that numpy 1.24 removed.
    if "bool" not in numpy.__dict__:
        numpy.bool = bool
    before = set(bpy.data.objects)
    if "FINISHED" not in bpy.ops.import_scene.gltf(filepath=str(path)):
        raise ImportFailed(f"{path}: Blender's importer could not read it")
    return [item for item in bpy.data.objects if item not in before]


def collection_of(path, document, objects, scene):
    animations = document.get("animations", [])
    name = animations[0]["name"] if len(animations) == 1 else pathlib.Path(path).stem
    collection = bpy.data.collections.new(name)  # Blender appends a number to a used name
    scene.collection.children.link(collection)
    for item in objects:
        for other in list(item.users_collection):
            other.objects.unlink(item)
        collection.objects.link(item)
    set_properties(collection, document.get("asset", {}).get("extras", {}))
    if len(animations) == 1:
        set_properties(collection, animations[0].get("extras", {}))
    else:
        # Several clips in one file share the objects; each clip has its own actions.
        collection["clips"] = json.dumps([dict(animation.get("extras", {}), name=animation["name"])
                                          for animation in animations])
    collection[END_S] = end_s_of(document)
    return collection


def ours(scene):
    return [one for one in scene.collection.children_recursive if END_S in one]


def import_files(paths, fps=24, scene=None):
    """Imports .glb files, each into its own collection, and returns the collections."""
    scene = scene or bpy.context.scene
    if ours(scene) and scene.get(FPS, fps) != fps:
        raise ImportFailed(f"this scene already contains animations at {scene[FPS]} frames per second; "
                           "import at the same rate, or into another scene")
    documents = [(path, document_of(path)) for path in paths]
    # The importer places keys by the scene's frame rate, so set the rate first.
    scene.render.fps = fps
    scene.render.fps_base = 1
    scene[FPS] = fps
    made = [collection_of(path, document, load_glb(path), scene) for path, document in documents]
    scene.frame_start = 0
    scene.frame_end = max([1] + [math.ceil(one[END_S] * fps - 1e-4) for one in ours(scene)])
    scene.frame_set(0)
    return made


def export_archive(program, archive, folder, ids="", whole_frames_fps=None, however_many=False):
    """Exports an archive's animations to a folder with `sleight`, and returns the files."""
    found = shutil.which(program)
    if found is None:
        raise ImportFailed(f"program '{program}' not found; set its path in the import "
                           "options, or export the archive yourself and choose the .glb files")
    command = [found, "export", str(archive), "-o", str(folder), "--json"]
    if whole_frames_fps:
        command += ["--fps", str(whole_frames_fps)]
    if however_many:
        command.append("--all")
    words = ids.replace(",", " ").split()
    if any(word.startswith("-") for word in words):
        raise ImportFailed(f"expected ids of animations such as c0.250, found: {ids}")
    if words:
        command += ["--ids", *words]
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace",
                              timeout=SECONDS_MAX, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise ImportFailed(f"{program}: {error}") from error
    if done.returncode != 0:
        raise ImportFailed(done.stderr.strip() or f"sleight exited with code {done.returncode}")
    return [written["path"] for written in json.loads(done.stdout)["written"]]


class ImportSleight(bpy.types.Operator, ImportHelper):
    """Import animations from Sleight, each into its own collection"""

    bl_idname = "import_scene.sleight"
    bl_label = "Import Sleight animations"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".glb"
    filter_glob: StringProperty(default="*.glb;*.h5", options={"HIDDEN"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement,
                              options={"HIDDEN", "SKIP_SAVE"})
    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    fps: IntProperty(name="Frame rate", description="Frames per second", default=24, min=1, max=1000)
    ids: StringProperty(name="Animations", default="",
                        description="For archives: ids of animations, such as c0.250 or find.3. Empty: all")
    however_many: BoolProperty(name="More than 100", default=False,
                               description="For archives: import all animations, even more than 100")
    whole_frames: BoolProperty(name="Keys on whole frames", default=False,
                               description="For archives: one keyframe on each frame, and no others")
    program: StringProperty(name="Program", default="sleight",
                            description="For archives: program that exports the animations")

    def chosen(self):
        names = [one.name for one in self.files if one.name]
        folder = pathlib.Path(self.directory)
        return [folder / name for name in names] or [pathlib.Path(self.filepath)]

    def execute(self, context):
        try:
            with tempfile.TemporaryDirectory(prefix="sleight-import-") as scratch:
                paths = []
                for number, path in enumerate(self.chosen()):
                    if path.suffix == ".h5":
                        folder = pathlib.Path(scratch) / str(number)
                        paths += export_archive(self.program, path, folder, self.ids,
                                                self.fps if self.whole_frames else None,
                                                self.however_many)
                    else:
                        paths.append(path)
                made = import_files(paths, self.fps, context.scene)
        except (ImportFailed, OSError, RuntimeError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{len(made)} animations imported")
        return {"FINISHED"}


def menu(self, _context):
    self.layout.operator(ImportSleight.bl_idname, text="Sleight animations (.glb, .h5)")


def register():
    bpy.utils.register_class(ImportSleight)
    bpy.types.TOPBAR_MT_file_import.append(menu)


def unregister():
    bpy.types.TOPBAR_MT_file_import.remove(menu)
    bpy.utils.unregister_class(ImportSleight)


if __name__ == "__main__":
    register()
