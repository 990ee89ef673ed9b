# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import pytest
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.settings import SettingError, Settings, fields, updated


def test_values_are_read_from_text():
    done = updated(RsmSettings(), {"samples": "12", "visibility": "off", "disk_radius": "0.5", "pattern": "disk"})
    assert (done.samples, done.visibility, done.disk_radius, done.pattern) == (12, False, 0.5, "disk")


@pytest.mark.parametrize(
    "name, text", [("samples", "0"), ("samples", "many"), ("pattern", "ring"), ("visibility", "maybe"),
        ("disk_radius", "nan"), ("colour", "1")]
)
def test_wrong_ones_are_named(name, text):
    with pytest.raises(SettingError, match=name):
        updated(RsmSettings(), {name: text})


@pytest.mark.parametrize("kind", [Settings, RsmSettings])
def test_every_setting_says_what_it_does_and_its_bounds(kind):
    for f in fields(kind):
        assert len(f.metadata["description"].split()) > 3, f.name
        assert isinstance(f.default, bool) or f.metadata["choices"] or f.metadata["low"] is not None, f.name


def test_islands_have_the_room_that_they_grow_into_unless_told_otherwise():
    assert Settings().room == Settings().margin > 0
    assert [Settings(margin=9, padding=padding).room for padding in (-1, 0, 2)] == [9, 0, 2]
