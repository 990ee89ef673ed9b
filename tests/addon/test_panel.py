# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties, operators and presets: what the panel does, without its window."""

import copy
import json
from dataclasses import fields
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from gi_bake.tests.addon.blocks import names
from gi_bake.tests.addon.interface_strings import classes, of_classes, of_source, properties, rna

METHODS = ("rsm", "lpv", "ssgi")


def test_settings_have_one_name_and_one_default_everywhere(gi):
    bpy.ops.wm.read_homefile(use_empty=True)
    asked, techniques = gi("addon.asked"), gi("gi_core.techniques").METHODS
    for method in METHODS:
        assert asked.settings(bpy.context.scene, method) == techniques[method].settings()


def test_settings_of_the_scene_reach_the_job(gi):
    scene, asked = bpy.context.scene, gi("addon.asked")
    group = scene.gi_bake
    group.denoise, group.ssgi.mode, group.ssgi.thickness, group.noise_threshold = "OIDN", "RAY_TRACED", 0.3, 0.01
    job = asked.job(scene, bpy.context.view_layer, method="ssgi", resolution=48, device="cpu")
    assert (job.method, job.target, job.resolution, job.settings.device) == ("ssgi", "image", 48, "cpu")
    found = job.settings
    assert (found.denoise, found.mode, found.thickness, found.noise_threshold) == ("oidn", "ray_traced", 0.3, 0.01)


def test_bounds_of_settings_are_blenders_too(gi):
    for method in METHODS:
        settings = gi("gi_core.techniques").METHODS[method].settings
        for f in fields(settings):
            group = bpy.context.scene.gi_bake
            holder = getattr(group, method) if f.name in getattr(group, method).bl_rna.properties else group
            if f.metadata["low"] is None:
                continue
            for value in (f.metadata["low"], f.metadata["high"]):
                setattr(holder, f.name, value)
                gi("addon.asked").settings(bpy.context.scene, method)  # raises out of bounds
            assert holder.bl_rna.properties[f.name].hard_max == pytest.approx(f.metadata["high"])


def test_every_property_operator_and_item_says_what_it_does(extension):
    package = extension.__name__
    assert len(classes(package)) > 30
    for cls in classes(package):
        for prop in properties(cls):
            said = prop.description
            assert len(said) > 12 and said != prop.name and not said.endswith("."), f"{cls.__name__}.{prop.identifier}"
        if issubclass(cls, bpy.types.Operator):
            said = rna(cls).description
            assert len(said) > 12 and not said.endswith("."), cls.__name__


def test_chinese_is_complete(gi):
    chinese = gi("addon.translations.zh_hans").ZH_HANS
    translated = {text for _, text in chinese}
    said = of_classes(gi("addon").__name__.removesuffix(".addon")) | of_source()
    assert len(said) > 300
    assert sorted(said - translated) == []
    for (_, text), other in chinese.items():
        assert other and other.count("{") == text.count("{"), text
    settings = [p for cls in classes(gi("addon").__name__.removesuffix(".addon")) for p in properties(cls)]
    assert {(p.translation_context, p.name) for p in settings} <= set(chinese)
    bound = bpy.context.scene.gi_bake.rsm.bl_rna.properties["bound"]
    assert (bound.translation_context, bound.name) == ("GI Bake", "Bound"), "which Blender takes for 'tied'"


def test_what_is_not_as_in_cycles_is_said_in_chinese(gi, sample):
    chinese, sentence = gi("addon.translations.zh_hans").ZH_HANS, gi("addon.sentence")

    def put(text):
        return sentence.translated(text, lambda template: chinese["*", template])

    reading = gi("addon.read.nodes").Reading(sentence.Sentence("Material '{name}'", name="{A}"), None, [])
    reading.note("its anisotropy is left out")
    assert reading.notes == ["Material '{A}': its anisotropy is left out."]
    assert put(reading.notes[0]) == "材质“{A}”：忽略其各向异性。"
    bpy.ops.wm.open_mainfile(filepath=str(sample("materials")))
    told = gi("addon.read").read_scene(bpy.context.scene, bpy.context.view_layer).approximated
    assert len(told) > 5
    assert [text for text in told if put(text) == text] == []


def test_findings_are_said_in_chinese_with_their_names(gi):
    scene, said = bpy.context.scene, gi("addon.sentence").translated
    chinese = {text: other for (_, text), other in gi("addon.translations.zh_hans").ZH_HANS.items()}
    scene.gi_bake.target, scene.gi_bake.unwrap = "LIGHTMAP", "NEVER"
    floor, ceiling = (bpy.data.objects[name].data for name in ("Floor", "Ceiling"))
    while floor.uv_layers:
        floor.uv_layers.remove(floor.uv_layers[0])
    for layer in ceiling.uv_layers:
        layer.uv.foreach_set("vector", np.full(2 * len(layer.uv), 0.5, np.float32))
    bpy.data.objects["Back wall"].hide_render = True
    with pytest.raises(RuntimeError, match="NO_UV_MAP"):
        bpy.ops.gi.check()
    found = gi("addon.session").session.findings(scene)
    assert {f.code for f in found} == {"NO_UV_MAP", "EMPTY_UV_MAP"}
    for finding in found:
        assert finding.object in finding.message and "has" in finding.message
        message = said(finding.message, chinese.__getitem__)
        assert finding.object in message and "has" not in message and message[-1] == "。"
        assert said(finding.remedy, chinese.__getitem__) in {"展开 UV。", "展开 UV。或将其排除。"}


def test_a_name_with_braces_stays_a_name(gi):
    sentence = gi("addon.sentence")
    inner = sentence.Sentence("no {thing}", thing="{map}")
    made = sentence.Sentence("'{name}' has {why}.", name="{0}", why=inner)
    assert made == "'{0}' has no {map}." and sentence.translated(made, str) == made
    assert copy.deepcopy(made) == made and json.loads(json.dumps([made])) == [made]
    assert sentence.translated(made, {"no {thing}": "kein {thing}", "'{name}' has {why}.": "{why}: {name}"}.get) == (
        "kein {map}: {0}"
    )


def test_a_check_makes_the_uvs_that_a_bake_would_make(gi):
    scene, floor = bpy.context.scene, bpy.data.objects["Floor"].data
    while floor.uv_layers:
        floor.uv_layers.remove(floor.uv_layers[0])
    scene.gi_bake.target, before = "LIGHTMAP", names()
    assert bpy.ops.gi.check() == {"FINISHED"}
    assert names() == before and not floor.uv_layers


def test_a_bake_puts_its_result_into_the_list_and_remove_takes_all_of_it_away(gi):
    before, group = names(), bpy.context.scene.gi_bake
    group.lpv.cells, group.lpv.cascades = 16, 1
    asked = [("RSM", "IMAGE"), ("RSM", "LIGHTMAP"), ("SSGI", "VERTICES"), ("LPV", "VOLUME")]
    for method, target in asked:
        assert bpy.ops.gi.bake(method=method, target=target) == {"FINISHED"}
    assert [(line.method, line.target) for line in group.results] == asked
    assert len(group.results[0].images) == 2 and len(group.results[1].images) == 7
    assert len(json.loads(group.results[2].objects)) == 7
    bpy.ops.gi.bake(target="LIGHTMAP")
    targets = [line.target for line in group.results]
    assert targets == ["IMAGE", "VERTICES", "VOLUME", "LIGHTMAP"], "it replaces its like"
    while len(group.results):
        assert bpy.ops.gi.remove() == {"FINISHED"}
    assert names() == before


def test_the_list_is_saved_with_the_file(gi, tmp_path):
    bpy.ops.gi.bake(target="LIGHTMAP", objects="Floor, Ceiling")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "baked.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "baked.blend"))
    [line] = bpy.context.scene.gi_bake.results
    assert sorted(part.image.name for part in line.images) == ["Ceiling Lightmap", "Floor Lightmap"]
    assert not bpy.ops.gi.compare.poll(), "the light is not in memory any more"


def test_images_go_to_the_folder_where_asked(gi, tmp_path):
    group = bpy.context.scene.gi_bake
    bpy.ops.gi.bake(target="LIGHTMAP", objects="Floor")
    packed = np.array(bpy.data.images["Floor Lightmap"].pixels[:])
    group.keep = "FILES"
    bpy.ops.gi.bake(target="LIGHTMAP", objects="Floor")
    image = bpy.data.images["Floor Lightmap"]
    assert image.source == "FILE" and image.packed_file is None
    assert (tmp_path / "out" / "Floor Lightmap.exr").is_file()
    assert np.array_equal(np.array(image.pixels[:]), packed)
    bpy.ops.gi.bake(target="IMAGE")
    assert bpy.data.images["Scene GI"].size[0] == 24 and bpy.data.images["Scene GI"].source == "FILE"


def test_a_folder_that_cannot_be_written_is_said_and_nothing_is_changed(gi, tmp_path):
    (tmp_path / "file").touch()
    bpy.context.scene.gi_bake.keep, before = "FILES", names()
    with pytest.raises(RuntimeError, match="OUTPUT_NOT_WRITABLE"):
        bpy.ops.gi.bake(folder=str(tmp_path / "file"))
    assert names() == before and not bpy.context.scene.gi_bake.results


def test_objects_left_out_or_not_selected_get_no_lightmap(gi):
    scene, asked = bpy.context.scene, gi("addon.asked")
    layer = bpy.context.view_layer
    assert asked.chosen_objects(scene, layer) == ()
    bpy.data.objects["Floor"].gi_bake.use = False
    assert "Floor" not in asked.chosen_objects(scene, layer) and len(asked.chosen_objects(scene, layer)) == 6
    scene.gi_bake.scope = "SELECTED"
    for obj in layer.objects:
        obj.select_set(obj.name == "Ceiling")
    assert asked.chosen_objects(scene, layer) == ("Ceiling",)
    bpy.data.objects["Ceiling"].select_set(False)
    with pytest.raises(RuntimeError, match="NOTHING_SELECTED"):
        bpy.ops.gi.bake(target="LIGHTMAP")


def test_what_is_baked_is_told_beforehand(gi):
    group, extent = bpy.context.scene.gi_bake, gi("addon.asked").extent

    def told():
        found = extent(bpy.context.scene, bpy.context.view_layer)
        bpy.ops.gi.bake()
        sizes = sorted(image.size[0] for image in bpy.data.images if image.name.endswith("Lightmap"))
        return found, sizes

    group.target, group.resolution = "LIGHTMAP", 16
    bpy.data.objects["Floor"].gi_bake.lightmap_factor = 2
    found, sizes = told()
    assert (found.objects, found.images, found.size) == (7, 7, "16² … 32²") and sizes == [16] * 6 + [32]
    assert found.points == sum(side**2 for side in sizes)
    group.atlas, group.resolution = "ALL", 64
    found = extent(bpy.context.scene, bpy.context.view_layer)
    assert (found.objects, found.images, found.points) == (7, 1, 64 * 64)
    group.atlas, group.density = "OBJECT", 8
    found = extent(bpy.context.scene, bpy.context.view_layer)
    bpy.ops.gi.bake()
    baked = sum(np.prod(part.image.size) for part in group.results[-1].images)
    assert found.images == 7 and 0.4 < found.points / baked < 2.5


def test_a_refused_bake_shows_its_findings_and_a_remedy_takes_them_away(gi):
    scene, session = bpy.context.scene, gi("addon.session").session
    scene.camera, before = None, names()
    for operator in (bpy.ops.gi.check, bpy.ops.gi.bake):
        with pytest.raises(RuntimeError, match="NO_CAMERA"):
            operator()
    assert [f.code for f in session.findings(scene)] == ["NO_CAMERA"] and names() == before
    assert bpy.ops.gi.add_camera() == {"FINISHED"}
    assert session.findings(scene) == ()
    scene.gi_bake.target = "LIGHTMAP"
    bpy.data.objects["Floor"].hide_render = True
    with pytest.raises(RuntimeError, match="HIDDEN_IN_RENDER"):
        bpy.ops.gi.bake(objects="Floor")
    assert bpy.ops.gi.show_in_render(objects="Floor") == {"FINISHED"}
    assert not bpy.data.objects["Floor"].hide_render
    mesh = bpy.data.objects["Floor"].data
    bpy.data.objects["Ceiling"].data = mesh
    with pytest.raises(RuntimeError, match="VERTICES_NOT_WRITABLE"):
        bpy.ops.gi.bake(target="VERTICES")
    assert bpy.ops.gi.make_single_user(objects='["Ceiling"]') == {"FINISHED"}
    assert bpy.ops.gi.bake(target="VERTICES") == {"FINISHED"}


def test_wrong_settings_are_said_and_nothing_is_changed(gi):
    before = names()
    with pytest.raises(RuntimeError, match="SETTING"):
        bpy.ops.gi.bake(method="RSM", target="VOLUME")
    assert names() == before and not bpy.context.scene.gi_bake.results


def test_polls_say_why_not(gi):
    session, ops = gi("addon.session").session, bpy.ops.gi
    assert ops.bake.poll() and ops.check.poll()
    for name in ("compare", "apply", "remove", "show", "cancel"):
        assert not getattr(ops, name).poll(), name
    session.run = SimpleNamespace(close=lambda: None)
    for name in ("bake", "check", "compare", "remove", "add_camera", "show_in_render", "make_single_user", "select"):
        assert not getattr(ops, name).poll(), name
    assert ops.cancel.poll()


def test_a_comparison_is_noted_and_shown_in_images(gi, tmp_path):
    group = bpy.context.scene.gi_bake
    bpy.ops.gi.bake(target="IMAGE")
    assert bpy.ops.gi.compare(samples=4, folder=str(tmp_path)) == {"FINISHED"}
    [line] = group.results
    told = json.loads((tmp_path / "report.json").read_text())["techniques"]["rsm"]
    told = told["comparisons"]["Diffuse Indirect"]
    assert line.compared and line.error == pytest.approx(told["relmse"]) and line.bias == pytest.approx(told["bias"])
    baked, cycles, difference = (part.image for part in line.comparisons if "Diffuse Indirect" in part.image.name)
    assert [image.name.split()[-1] for image in (baked, cycles, difference)] == ["Baked", "Cycles", "Difference"]
    ours = bpy.data.images["Scene GI Indirect"]
    assert np.array_equal(np.array(baked.pixels), np.array(ours.pixels)), "which Blender shows alike"
    assert baked.packed_file and baked.colorspace_settings.name == ours.colorspace_settings.name
    reference = gi("gi_core.exr").read_layers(tmp_path / "reference.exr")["Diffuse Indirect"]
    assert np.allclose(np.array(cycles.pixels).reshape(24, 24, 4)[..., :3], reference[..., :3])


def test_the_buttons_of_a_comparison_show_the_same_part_by_another(gi, tmp_path, monkeypatch):
    bpy.ops.gi.bake(target="LIGHTMAP", objects="Floor, Ceiling")
    assert bpy.ops.gi.compare(samples=1, folder=str(tmp_path)) == {"FINISHED"}
    space, preview = SimpleNamespace(image=None), gi("addon.preview")
    monkeypatch.setattr(preview, "editors", lambda: [space])
    monkeypatch.setattr(preview, "show", lambda image: setattr(space, "image", image) or True)

    def shown(which):
        assert bpy.ops.gi.show(which=which) == {"FINISHED"}
        return space.image.name

    first = shown("BAKED")
    assert first.endswith(" Baked") and shown("CYCLES") == first.replace("Baked", "Cycles")
    second = shown("CYCLES")
    assert second.endswith(" Cycles") and second != first.replace("Baked", "Cycles"), "the next part"
    assert shown("DIFFERENCE") == second.replace("Cycles", "Difference")
    bpy.data.images.remove(space.image)
    space.image = bpy.data.images[second]
    assert shown("DIFFERENCE").endswith(" Difference"), "one that is gone is passed over"


def test_light_at_vertices_is_shown_in_the_3d_view_and_taken_away_whole(gi):
    before = names()
    attributes = {"CORNER": "gi_irradiance_corner", "POINT": "gi_irradiance"}
    for domain in ("CORNER", "POINT", "CORNER"):
        bpy.context.scene.gi_bake.domain = domain
        bpy.ops.gi.bake(target="VERTICES")
        assert bpy.ops.gi.show() == {"FINISHED"}
        mesh = bpy.data.objects["Floor"].data
        assert mesh.color_attributes.active_color.name == attributes[domain]
        assert [key for key in mesh.attributes.keys() if key.startswith("gi_")] == [attributes[domain]]
    views = [a.spaces.active for w in bpy.context.window_manager.windows for a in w.screen.areas if a.type == "VIEW_3D"]
    assert all((v.shading.type, v.shading.color_type) == ("SOLID", "VERTEX") for v in views)
    bpy.ops.gi.remove()
    assert names() == before


def test_light_at_vertices_is_applied_and_removed_whole(gi):
    before = names()
    bpy.ops.gi.bake(target="VERTICES")
    assert bpy.ops.gi.apply() == {"FINISHED"} and "GI Lightmap" in bpy.data.node_groups
    mesh = bpy.data.objects["Floor"].data
    mesh_keys = set(mesh.keys())
    for name in json.loads(bpy.context.scene.gi_bake.results[0].objects):
        del bpy.data.objects[name].data["gi_lightmap_light"]
    with pytest.raises(RuntimeError, match="has a lightmap or light at its vertices: bake") as error:
        bpy.ops.gi.apply()
    assert "Traceback" not in str(error.value)
    bpy.ops.gi.bake(target="VERTICES")
    assert set(mesh.keys()) == mesh_keys
    assert bpy.ops.gi.remove() == {"FINISHED"} and names() == before and not set(mesh.keys()) & mesh_keys


def test_files_are_remembered_from_the_blend(gi, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    bpy.context.scene.gi_bake.folder, bpy.context.scene.gi_bake.keep = "//out/", "FILES"
    bpy.ops.gi.bake(target="IMAGE")
    bpy.ops.gi.compare(samples=1)
    [line] = bpy.context.scene.gi_bake.results
    assert (line.folder, line.report) == ("//out", "//out/report.html")
    assert (tmp_path / "out" / "report.html").is_file()


def test_the_same_panels_are_there_for_every_technique(gi):
    """Of two sub-panels that take each other's place and are as high, Blender does not show the second."""
    group, panels = bpy.context.scene.gi_bake, gi("addon.ui")._panels
    for target in (item.identifier for item in group.bl_rna.properties["target"].enum_items):
        shown = set()
        for group.target, group.method in ((target, method.upper()) for method in METHODS):
            shown.add(tuple(panel for panel in panels if not hasattr(panel, "poll") or panel.poll(bpy.context)))
        assert len(shown) == 1


def test_the_long_stage_is_called_by_what_is_done(gi):
    group, stages, words = bpy.context.scene.gi_bake, {}, gi("addon.ui.main").STAGES
    group.lpv.cells, group.ssgi.frames = 16, 1
    asked, bake = gi("addon.asked"), gi("addon.bake").bake
    for method in METHODS:
        job = asked.job(bpy.context.scene, bpy.context.view_layer, method=method)
        stages[method] = {stage for _, stage in bake(bpy.context.scene, bpy.context.view_layer, job)}
        assert stages[method] <= words.keys()
    assert "propagation" in stages["lpv"] and "screen" in stages["ssgi"] and "maps" in stages["rsm"]
    assert "maps" not in stages["lpv"] | stages["ssgi"]


def test_shipped_presets_set_what_they_say(gi):
    asked = gi("addon.asked")
    for method in METHODS:
        found = []
        for quality in ("draft", "medium", "high"):
            path = bpy.utils.preset_find(quality, f"gi_bake/{method}")
            done = bpy.ops.script.execute_preset(filepath=path, menu_idname=f"GI_PT_{method}_presets")
            assert done == {"FINISHED"}
            found.append(asked.settings(bpy.context.scene, method))
        assert len(set(found)) == 3
    assert [s.samples for s in found] == sorted(s.samples for s in found)


def test_a_users_preset_comes_back(gi):
    group = bpy.context.scene.gi_bake
    group.samples, group.rsm.pattern = 123, "DISK"
    assert bpy.ops.gi.rsm_preset_add(name="Mine of test") == {"FINISHED"}
    path = bpy.utils.preset_find("Mine_of_test", "gi_bake/rsm")
    group.samples, group.rsm.pattern = 1, "ALL"
    bpy.ops.script.execute_preset(filepath=path, menu_idname="GI_PT_rsm_presets")
    assert (group.samples, group.rsm.pattern) == (123, "DISK")
    bpy.ops.gi.rsm_preset_add(name="Mine_of_test", remove_name=True)
    assert not bpy.utils.preset_find("Mine_of_test", "gi_bake/rsm")


def test_the_cache_is_counted_and_cleared(gi, tmp_path, monkeypatch):
    preferences = gi("addon.preferences")
    bpy.ops.gi.bake(target="IMAGE")  # which leaves its time there
    assert preferences.cache_size() > 0
    timing = gi("addon.timing")
    assert timing.expected(bpy.context.scene, bpy.context.view_layer) > 0
    textures = gi("addon.read.texture_cache")
    monkeypatch.setenv("GI_BAKE_CACHE", str(tmp_path / "materials"))
    before = preferences.cache_size()
    textures.TextureCache(textures.default_folder()).save("key", np.zeros((8, 8, 3), np.float32))
    (tmp_path / "materials" / "of somebody").touch()
    assert preferences.cache_size() > before
    assert bpy.ops.gi.clear_cache() == {"FINISHED"}
    assert [path.name for path in (tmp_path / "materials").iterdir()] == ["of somebody"]
    monkeypatch.delenv("GI_BAKE_CACHE")
    preferences.preferences().cache = str(tmp_path)
    assert textures.default_folder() == tmp_path / "gi_bake" / "materials"
    preferences.preferences().cache = ""
    assert textures.default_folder() != tmp_path / "gi_bake" / "materials"
    monkeypatch.setenv("GI_BAKE_CACHE", str(tmp_path / "materials"))
    assert preferences.cache_size() == 0 and not bpy.ops.gi.clear_cache.poll()


def test_threads_change_no_result(gi):
    preferences, tiles = gi("addon.preferences"), gi("gi_core.tiles")
    found = []
    for threads in (1, 3):
        preferences.preferences().threads = threads
        assert tiles._threads == [threads]
        bpy.ops.gi.bake(target="IMAGE")
        found.append(np.array(bpy.data.images["Scene GI"].pixels[:]))
    preferences.preferences().threads = 0
    assert np.array_equal(*found)


def test_several_scenes_and_view_layers_keep_to_themselves(gi):
    first = bpy.context.scene
    second = first.copy()
    layer = second.view_layers.new("Floor only")
    with bpy.context.temp_override(scene=second, view_layer=layer):
        assert bpy.ops.gi.bake(target="IMAGE") == {"FINISHED"}
    assert not first.gi_bake.results
    [line] = second.gi_bake.results
    assert line.view_layer == "Floor only" and line.name == second.name


def test_every_operator_fails_as_it_should(gi, tmp_path):
    """What each says where it cannot do anything, or that it cannot even be asked for; and none while a bake is on."""
    scene, ops, session = bpy.context.scene, bpy.ops.gi, gi("addon.session").session
    (tmp_path / "file").touch()
    nobody = '["Nobody"]'
    bpy.ops.gi.bake(target="IMAGE")

    def error(operator, match, **given):
        with pytest.raises(RuntimeError, match=match):
            operator(**given)

    def no_camera(operator):
        scene.camera = None
        error(operator, "NO_CAMERA")
        scene.camera = bpy.data.objects["Camera"]

    def nothing_to_show():
        for image in list(bpy.data.images):
            bpy.data.images.remove(image)
        assert ops.show() == {"CANCELLED"}

    fails = {
        "bake": lambda: error(ops.bake, "UNKNOWN_OBJECT", target="LIGHTMAP", objects="Nobody"),
        "cancel": lambda: error(ops.cancel, "poll"),
        "check": lambda: no_camera(ops.check),
        "compare": lambda: error(ops.compare, "NOT_WRITTEN", samples=1, folder=str(tmp_path / "file")),
        "apply": lambda: error(ops.apply, "poll"),
        "show": nothing_to_show,
        "make_uvs": lambda: ops.make_uvs(objects='["Floor"]') == {"CANCELLED"},
        "show_in_render": lambda: ops.show_in_render(objects=nobody) == {"CANCELLED"},
        "make_single_user": lambda: ops.make_single_user(objects=nobody) == {"CANCELLED"},
        "select": lambda: ops.select(objects=nobody) == {"CANCELLED"},
    }
    cannot = {"remove", "add_camera", "use_bilateral", "clear_cache", *(f"{m}_preset_add" for m in METHODS)}
    there = {cls.bl_idname.removeprefix("gi.") for cls in classes(gi("addon").__name__.removesuffix(".addon"))
             if issubclass(cls, bpy.types.Operator)}  # fmt: skip
    assert there == fails.keys() | cannot
    for name, fail in fails.items():
        before = names()
        assert fail() in {None, True}, name
        assert name == "show" or names() == before, name
    session.run = SimpleNamespace(close=lambda: None)
    polls = {name: getattr(ops, name).poll() for name in there}
    session.run = None
    free = {"cancel", "show", "clear_cache", *(f"{m}_preset_add" for m in METHODS)}
    assert not any(polls[name] for name in there - free), polls
