"""Which elements and tangent "auto" stands for, by what a scene has."""

from __future__ import annotations

from dataclasses import replace

import pytest

from warp_softbody import scenes
from warp_softbody.body.material import Volume
from warp_softbody.engine.option_choice import with_choices
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.world.scene import Scene


def muscular(volume: Volume) -> Scene:
    scene = scenes.make("balance-i").scene
    material = replace(scene.character.material, volume=volume)
    return replace(scene, character=replace(scene.character, material=material))


def chosen(scene: Scene, **given: str) -> tuple[str, str]:
    made = with_choices(SimulationOptions(**given), scene)  # type: ignore[arg-type]
    return made.elements, made.tangent


def test_a_body_with_muscles_gets_elements_that_hardly_lock_and_keep_its_spin() -> None:
    assert chosen(muscular("exact")) == ("smoothed", "conserving")


def test_smoothed_elements_without_exact_volume_have_the_warped_tangent_only() -> None:
    assert chosen(muscular("linear")) == ("smoothed", "warped")
    assert chosen(muscular("linear"), elements="linear") == ("linear", "conserving")


def test_a_passive_scene_models_no_more_than_it_needs() -> None:
    assert chosen(scenes.make("drop-block").scene) == ("linear", "warped")


def test_one_muscular_body_among_others_decides() -> None:
    scene = muscular("exact")
    others = scenes.make("stack").scene.others
    material = replace(others[0].character.material, volume="exact")
    other = replace(others[0], character=replace(others[0].character, material=material))
    assert chosen(replace(scene, others=(other,))) == ("smoothed", "conserving")
    assert chosen(replace(scene, others=others[:1])) == ("smoothed", "warped")


@pytest.mark.parametrize("tangent", ["warped", "conserving"])
@pytest.mark.parametrize("elements", ["linear", "smoothed"])
def test_what_is_asked_for_stays(elements: str, tangent: str) -> None:
    assert chosen(muscular("exact"), elements=elements, tangent=tangent) == (elements, tangent)


def test_the_exact_tangent_is_one_of_linear_elements() -> None:
    assert chosen(muscular("exact"), tangent="exact") == ("linear", "exact")


def test_a_conserving_tangent_asked_for_decides_where_smoothed_elements_lack_it() -> None:
    assert chosen(muscular("linear"), tangent="conserving") == ("linear", "conserving")
    assert chosen(muscular("exact"), tangent="conserving") == ("smoothed", "conserving")
