from hairpipe.nodes.make_bust import make_bust


def test_the_bust_is_ready_for_hair_and_motion():
    body = make_bust()
    assert body.skeleton.names == ("chest", "neck", "neck1", "head")
    assert {"scalp", "length"} <= set(body.maps)
    assert len(body.weights) == len(body.joints) == len(body.mesh.points) == len(body.maps["scalp"])
    assert body.mesh.uv.shape == (len(body.mesh.triangles), 3, 2)
