"""Dependency directions: links obey the law, includes follow the links, no cycles.

common links only common; worker, service and clients link common and themselves; physics and
sampling don't depend on each other. Only a program's main*.cpp may join sides."""

from .cmake import SIDES, Project
from .tree import Finding, includes, is_cpp

STRANGERS = (("worker/physics", "worker/sampling"), ("worker/sampling", "worker/physics"))


def check(tree):
    project = Project(tree)
    yield from _links(project)
    yield from _cycles(project)
    for path in tree.files:
        if is_cpp(path) and path.split("/")[0] in SIDES:
            yield from _includes(tree, project, path)


def _may_know(side, other):
    return other in ("common", side)


def _links(project):
    for library in project.libraries.values():
        side = library.folder.split("/")[0]
        for name, line in library.links:
            if name.split("_")[0] not in SIDES:
                continue
            linked = project.libraries.get(name)
            if linked is None:
                yield Finding(library.cmake, line, f"links {name}, which no folder declares")
            elif not _may_know(side, linked.folder.split("/")[0]):
                yield Finding(library.cmake, line,
                              f"{library.folder} must not link {linked.folder}: {side} may link "
                              f"common{'' if side == 'common' else ' and ' + side} alone")
        closure = project.closure(library)
        for folder, stranger in STRANGERS:
            if library.folder == folder and stranger.replace("/", "_") in closure:
                yield Finding(library.cmake, library.line,
                              f"{folder} must not link {stranger}, not even through others")


def _cycles(project):
    for library in project.libraries.values():
        for name, line in library.links:
            linked = project.libraries.get(name)
            if linked and (linked is library or library.name in project.closure(linked)):
                yield Finding(library.cmake, line, f"a cycle: {library.name} links {name}, which "
                                                   f"links {library.name}")


def _includes(tree, project, path):
    own = project.library_of(path)
    programs = project.programs_of(path)
    is_main = project.is_main(path)
    if own is None and not programs:
        yield Finding(path, 1, "no sleight_library or sleight_program in a CMakeLists.txt holds "
                               "this file")
        return
    allowed = {own.name} | project.closure(own) if own else set()
    for program in programs:
        allowed |= project.closure(program)
    side = path.split("/")[0]
    for line, name, quoted in includes(tree, path):
        top = name.split("/")[0]
        if top == "tests" and quoted:
            yield Finding(path, line, f"shipped code must not include {name}")
        elif top not in SIDES:
            if quoted:
                yield Finding(path, line, f'write "{name}" from the root: "folder/file.h"')
        else:
            yield from _include(project, path, line, name, side, allowed, is_main)


def _include(project, path, line, name, side, allowed, is_main):
    held_by = project.library_of(name)
    if held_by is None:
        if name.rsplit("/", 1)[0] != path.rsplit("/", 1)[0]:
            yield Finding(path, line, f"includes {name}, which no sleight_library holds")
        return
    other = held_by.folder.split("/")[0]
    if not is_main and not _may_know(side, other):
        yield Finding(path, line, f"{side} must not include {other}: {name}")
    elif any(path.startswith(a + "/") and held_by.folder == b for a, b in STRANGERS):
        yield Finding(path, line, f"physics and sampling do not know each other: {name}")
    elif held_by.name not in allowed:
        yield Finding(path, line, f"includes {name} without a link to {held_by.name}")
