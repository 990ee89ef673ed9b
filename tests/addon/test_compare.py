# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison as a whole: planted errors show in its numbers, and a reference is kept as long as it holds."""

import json
import math
from dataclasses import replace

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.compare import compare, edges, halves
from gi_bake.addon.compare.fingerprint import fingerprint
from gi_bake.addon.job import Job
from gi_bake.addon.write import lightmap_uvs
from gi_bake.gi_core import exr, metrics, sh, tiles
from gi_bake.gi_core.lpv.settings import LpvSettings
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.trace import Tracer
from gi_bake.tests.addon import page

SIDE = 48


def opened(sample, name):
    bpy.ops.wm.open_mainfile(filepath=str(sample(name)))
    return bpy.context.scene, bpy.context.view_layer


def baked(scene, layer, method="rsm", **settings):
    kind = {"rsm": RsmSettings, "lpv": LpvSettings}[method]
    settings = {"map_resolution": 128, **settings}
    return tiles.finish(bake(scene, layer, Job(method=method, resolution=SIDE, settings=kind(**settings))))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """One folder for all planted errors, so that Cycles renders their scene once."""
    return tmp_path_factory.mktemp("planted")


def albedo(scene, monkeypatch):
    """Everything reflects a tenth more than it should: first bounces are 10 % too bright."""
    from gi_bake.addon import preflight

    read = preflight.inspecting

    def brighter(*arguments, **more):
        findings, core = yield from read(*arguments, **more)
        materials = tuple(replace(m, albedo=replace(m.albedo, value=m.albedo.value * 1.1)) for m in core.materials)
        return findings, replace(core, materials=materials)

    monkeypatch.setattr(preflight, "inspecting", brighter)


def lights(scene, monkeypatch):
    """A factor of π on lamps, as forgetting what irradiance is makes."""
    for obj in scene.objects:
        if obj.type == "LIGHT":
            obj.data.energy *= math.pi


def shadows(scene, monkeypatch):
    through = Tracer.transmittance
    monkeypatch.setattr(Tracer, "transmittance", lambda *arguments: np.ones_like(through(*arguments)))
    monkeypatch.setattr(Tracer, "occluded", lambda self, origins, *more: np.zeros(len(origins), bool))


def signs(scene, monkeypatch):
    """The second band of each lobe turned round."""
    lobe = sh.cosine_lobe

    def flipped(*arguments):
        coefficients = lobe(*arguments).copy()
        coefficients[..., 1:4] *= -1
        return coefficients

    monkeypatch.setattr(sh, "cosine_lobe", flipped)


@pytest.mark.parametrize(
    "method, plant, settings, bias",
    [
        ("rsm", albedo, {}, {"Diffuse Indirect": 0.1}),
        ("rsm", lights, {}, {"Diffuse Indirect": math.pi - 1, "Diffuse Direct": math.pi - 1}),
        ("rsm", shadows, {}, {"Diffuse Indirect": None, "Diffuse Direct": None}),
        ("lpv", signs, {"cells": 16}, {"Diffuse Indirect": None}),
    ],
)
def test_a_planted_error_is_seen(sample, folder, monkeypatch, method, plant, settings, bias):
    scene, layer = opened(sample, "cornell")
    good = baked(scene, layer, method, **settings)
    with monkeypatch.context() as patch:
        plant(scene, patch)
        bad = baked(scene, layer, method, **settings)
    scene, layer = opened(sample, "cornell")
    report = compare({"good": good, "bad": bad}, scene, layer, 256, folder)
    told = json.loads((folder / "report.json").read_text())
    assert told["techniques"]["bad"]["comparisons"] == report.metrics["bad"]
    for kind, much in bias.items():
        right, wrong = (report.metrics[label][kind] for label in ("good", "bad"))
        noise = told["reference"]["noise"][kind]["relmse"]
        assert wrong["relmse"] - noise > 2 * (right["relmse"] - noise) and wrong["relmse"] > 1.2 * right["relmse"]
        assert wrong["rmse"] > right["rmse"] and wrong["flip"] > right["flip"] and wrong["psnr"] < right["psnr"]
        if much is not None:
            assert wrong["bias"] - right["bias"] == pytest.approx(much, rel=0.05)


def test_the_reference_is_kept_until_something_changes(sample, tmp_path, monkeypatch):
    scene, layer = opened(sample, "cornell")
    result = baked(scene, layer, samples=2)
    renders = []
    real = halves.camera_passes
    monkeypatch.setattr(halves, "camera_passes", lambda *a, **k: renders.append(k) or real(*a, **k))

    def told(result, samples=8):
        compare(result, scene, layer, samples, tmp_path)
        return json.loads((tmp_path / "report.json").read_text())["reference"]

    first = told(result)
    assert len(renders) == 2 and renders[0]["seed"] != renders[1]["seed"] and renders[0]["samples"] == 4
    again = told(result)
    assert len(renders) == 2 and "kept" in again["rendered"] and "kept" not in first["rendered"]
    assert again["noise"] == first["noise"]
    # Not by the file, which is the same: by what is in it, and by the terms.
    told(result, 16)
    assert len(renders) == 4
    bpy.data.objects["Floor"].active_material.node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value[0] *= 0.9
    layer.update()
    told(result, 16)
    assert len(renders) == 6
    told(baked(scene, layer, samples=2, bounces=2), 16)
    assert len(renders) == 8
    # A file that ends in the middle is no reference.
    kept = tmp_path / "reference.npz"
    kept.write_bytes(kept.read_bytes()[:-1000])
    told(baked(scene, layer, samples=2, bounces=2), 16)
    assert len(renders) == 10


def test_noise_is_that_of_the_mean(sample, tmp_path):
    """Of many samples against the kept mean of few: the error is what the two halves foretold."""
    scene, layer = opened(sample, "cornell")
    result = baked(scene, layer, samples=2)
    few = halves.truth(scene, layer, result.job, (SIDE, SIDE), {}, 32, tmp_path)
    many = halves.truth(scene, layer, result.job, (SIDE, SIDE), {}, 1024, tmp_path)
    error = np.mean((few.light["Diffuse Indirect"] - many.light["Diffuse Indirect"]) ** 2)
    assert np.mean(few.noise["Diffuse Indirect"] ** 2) == pytest.approx(error, rel=0.25)


def change(what):
    scene = bpy.context.scene
    floor, lamp = bpy.data.objects["Floor"], next(o for o in scene.objects if o.type == "LIGHT")
    nodes = floor.active_material.node_tree.nodes
    if what == "a vertex":
        floor.data.vertices[0].co.x += 0.01
    elif what == "a place":
        floor.location.z += 0.01
    elif what == "a lamp":
        lamp.data.energy *= 1.01
    elif what == "a lamp's visibility":
        lamp.visible_diffuse = not lamp.visible_diffuse
    elif what == "the world":
        scene.world = scene.world or bpy.data.worlds.new("World")
        scene.world.color[0] += 0.1
        if scene.world.node_tree:
            scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value += 0.1
    elif what == "the camera":
        scene.camera.data.lens += 1
    elif what == "a node":
        nodes.new("ShaderNodeTexNoise").inputs["Scale"].default_value = 7
        floor.active_material.node_tree.links.new(nodes[-1].outputs[0], nodes["Diffuse BSDF"].inputs["Roughness"])
    elif what == "a picture":
        image = bpy.data.images.new("i", 4, 4)
        nodes.new("ShaderNodeTexImage").image = image
        bpy.context.view_layer.update()
        yield
        image.pixels[5] = 0.25
        image.update()
    elif what == "hidden":
        floor.hide_render = True
    elif what == "transparency":
        scene.cycles.transparent_max_bounces += 1
    bpy.context.view_layer.update()
    yield


@pytest.mark.parametrize(
    "what",
    ["a vertex", "a place", "a lamp", "a lamp's visibility", "the world", "the camera", "a node", "a picture", "hidden",
     "transparency"],
)  # fmt: skip
def test_what_a_render_shows_changes_its_fingerprint(sample, what):
    scene, layer = opened(sample, "cornell")
    seen = [fingerprint(scene, layer)]
    seen += [fingerprint(scene, layer) for _ in change(what)]
    assert len(set(seen)) == len(seen)


@pytest.mark.parametrize("name", ["cornell", "materials", "props"])
def test_what_a_render_does_not_show_leaves_the_fingerprint(sample, name):
    scene, layer = opened(sample, name)
    before = fingerprint(scene, layer)
    for obj in list(layer.objects)[:3]:
        obj.select_set(not obj.select_get())
    layer.objects.active = layer.objects[0]
    scene.cycles.samples, scene.cycles.seed, scene.render.filepath = 7, 3, "//elsewhere"
    scene.view_settings.exposure = 2
    for obj in layer.objects:
        for slot in obj.material_slots:
            if slot.material and slot.material.node_tree:
                slot.material.node_tree.nodes[0].location.x += 10
    assert fingerprint(scene, layer) == before
    # Nor does opening the file again, where all addresses are others.
    scene, layer = opened(sample, name)
    assert fingerprint(scene, layer) == before


def test_edges_are_where_surfaces_lie_one_behind_the_other():
    """A wall, a step of 10 % of the distance before it, a slanted floor seen at a grazing angle, and nothing beyond."""
    side = 16
    across, up = np.meshgrid(np.arange(side), np.arange(side))
    distance = np.full((side, side), 10.0)
    distance[:, 8:] = 9.0
    position = np.dstack([across * 0.1, up * 0.1, -distance])
    normal = np.zeros((side, side, 3))
    normal[..., 2] = 1
    mask = edges.smooth(position, normal, distance)
    assert (mask == ((across != 7) & (across != 8))).all()
    # Twice as far with each pixel, but one plane.
    far = 2.0**up
    floor = np.dstack([across * 0.1 * far, -np.ones_like(far), -far])
    assert edges.smooth(floor, np.broadcast_to([0.0, 1.0, 0.0], floor.shape), far).all()
    distance[12:] = 1e10
    assert not edges.smooth(position, normal, distance)[11:13].any()


def test_lightmaps_and_vertices_are_compared_object_by_object(sample, tmp_path):
    scene, layer = opened(sample, "cornell")
    names = ("Floor", "Ceiling")
    for target in ("lightmap", "vertices"):
        job = Job(target=target, objects=names, resolution=16, settings=RsmSettings(samples=8, map_resolution=64))
        report = compare(tiles.finish(bake(scene, layer, job)), scene, layer, 16, tmp_path)
        kinds = ("{}, indirect", "{}, direct", "{}, direct and indirect")
        assert set(report.metrics["rsm"]) == {kind.format(name) for name in names for kind in kinds}
    maps = sorted((tmp_path / "reference").iterdir())
    assert len(maps) == 4 and exr.read_layers(maps[0])["Combined"].shape == (16, 16, 4)


def test_objects_that_share_a_lightmap_are_compared_each_in_its_place(sample, tmp_path):
    scene, layer = opened(sample, "cornell")
    names = ("Floor", "Short box", "Back wall")
    settings = RsmSettings(samples=128, map_resolution=512, atlas="all", light="indirect")
    result = tiles.finish(bake(scene, layer, Job(target="lightmap", objects=names, resolution=64, settings=settings)))
    lightmap_uvs.put_all({bpy.data.meshes[name, None]: uvs for name, uvs in result.uvs.items()})
    report = compare(result, scene, layer, 128, tmp_path)
    [page] = result.pages
    assert {subject.name for subject in report.subjects} == {f"{name}, indirect" for name in names}
    for subject, place in zip(report.subjects, page.places):
        assert subject.mask.shape == (place.side, place.side) and place.side < 64
        assert subject.mask.mean() > 0.2
        assert abs(report.metrics["rsm"][subject.name]["bias"]) < 0.06
        assert report.metrics["rsm"][subject.name]["relmse"] < 0.04
    # Walls are lit from one side: turned about, they do not fit.
    wall = report.subjects[names.index("Back wall")]
    turned = wall.ours["rsm"][:, ::-1][wall.mask]
    assert metrics.relmse(turned, wall.reference[wall.mask]) > 2 * wall.measures["rsm"]["relmse"]


def test_what_was_baked_differently_is_not_compared(sample, tmp_path):
    scene, layer = opened(sample, "cornell")
    results = {str(n): baked(scene, layer, samples=2, bounces=n) for n in (1, 2)}
    with pytest.raises(ValueError, match="cannot be compared"):
        compare(results, scene, layer, 4, tmp_path)
    assert not any(tmp_path.iterdir())


def test_its_page_works_and_the_reference_lies_there_as_an_image_too(sample, tmp_path):
    scene, layer = opened(sample, "cornell")
    report = compare(baked(scene, layer, samples=2), scene, layer, 8, tmp_path)
    found = page.driven(tmp_path / "report.html", tmp_path)
    assert found["errors"] == [] and found["shown"] == {k: [k] for k in ("indirect", "direct", "combined")}
    layers = exr.read_layers(tmp_path / "reference.exr")
    assert tmp_path / "reference.exr" in report.paths
    spread = layers["Diffuse Indirect Noise"]
    assert spread.shape == (SIDE, SIDE, 3) and spread.any()
    ours = exr.read_layers(tmp_path / "reference.exr")["Diffuse Indirect"]
    assert metrics.bias(ours, ours + spread) == pytest.approx(0, abs=0.2)
