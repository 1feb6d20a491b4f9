"""Bodies of a model that are fixed to each other."""

from tests import needs

mujoco = needs.module("mujoco")

from carom.server.bridge.mujoco.model import parts_of, welded_to  # noqa: E402

MODEL = """<mujoco><worldbody>
<geom type="plane" size="1 1 .1"/>
<body name="post"><geom size=".1"/><body name="knob"><geom size=".05"/></body></body>
<body name="bat" mocap="true"><geom size=".02"/><body name="tip"><geom size=".01"/></body></body>
<body name="arm"><joint/><geom size=".1"/><body name="pad"><geom size=".05"/>
  <body name="ball"><joint/><geom size=".02"/></body></body></body>
</worldbody></mujoco>"""


def test_bodies_are_fixed_to_one_that_has_a_joint_or_is_led_by_its_pose():
    model = mujoco.MjModel.from_xml_string(MODEL)
    names = ["world", "post", "knob", "bat", "tip", "arm", "pad", "ball"]
    of = {name: names[number] for name, number in zip(names, welded_to(model), strict=True)}
    assert [of[name] for name in names] == ["world", "world", "world", "bat", "bat", "arm", "arm", "ball"]
    assert {part.name for part in parts_of(model) if part.body} == {"bat", "arm", "ball"}


def test_bodies_that_no_pose_leads_are_fixed_as_mujoco_says():
    model = mujoco.MjModel.from_xml_string(MODEL.replace(' mocap="true"', ""))
    assert (welded_to(model) == model.body_weldid).all()
