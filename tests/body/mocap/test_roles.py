import pytest

from hairpipe.body.roles import Role, find_roles, match_roles, plain_names, spread

CONVENTIONS = """
cmu: Hips, LowerBack, Spine, Spine1, Neck, Neck1, Head, LHipJoint, LeftUpLeg, LeftLeg, LeftFoot, LeftShoulder,
    LeftArm, LeftForeArm, LeftHand, LeftHandIndex1, LThumb
    = Hips Head LeftShoulder LeftArm LeftForeArm LeftHand LeftUpLeg LeftLeg LeftFoot
daz: hip, abdomen, chest, neck, head, leftEye, lButtock, lThigh, lShin, lFoot, lCollar, lShldr, lForeArm, lHand,
    lThumb1, lIndex1
    = hip head lCollar lShldr lForeArm lHand lThigh lShin lFoot
mixamo: mixamorig:Hips, mixamorig:Spine, mixamorig:Spine1, mixamorig:Neck, mixamorig:Head, mixamorig:LeftUpLeg,
    mixamorig:LeftLeg, mixamorig:LeftFoot, mixamorig:LeftShoulder, mixamorig:LeftArm, mixamorig:LeftForeArm,
    mixamorig:LeftHand
biped: Bip01 Pelvis, Bip01 Spine, Bip01 Neck, Bip01 Head, Bip01 L Thigh, Bip01 L Calf, Bip01 L Foot, Bip01 L Clavicle,
    Bip01 L UpperArm, Bip01 L Forearm, Bip01 L Hand
joints: Hips, Chest, Neck, Head, LeftHip, LeftKnee, LeftAnkle, LeftCollar, LeftShoulder, LeftElbow, LeftWrist
    = Hips Head LeftCollar LeftShoulder LeftElbow LeftWrist LeftHip LeftKnee LeftAnkle
unreal: root, pelvis, spine_01, spine_02, neck_01, head, thigh_l, calf_l, foot_l, clavicle_l, upperarm_l, lowerarm_l,
    hand_l
    = pelvis head clavicle_l upperarm_l lowerarm_l hand_l thigh_l calf_l foot_l
makehuman: root, spine05, spine04, neck01, neck02, head, pelvis.L, upperleg01.L, upperleg02.L, lowerleg01.L, foot.L,
    clavicle.L, shoulder01.L, upperarm01.L, upperarm02.L, lowerarm01.L, wrist.L
    = root head clavicle.L upperarm01.L lowerarm01.L wrist.L upperleg01.L lowerleg01.L foot.L
asf: root, lowerback, upperback, thorax, lowerneck, upperneck, head, lclavicle, lhumerus, lradius, lwrist, lhand,
    lfingers, lthumb, lhipjoint, lfemur, ltibia, lfoot, ltoes
    = root head lclavicle lhumerus lradius lwrist lfemur ltibia lfoot
vrm: Root, J_Bip_C_Hips, J_Bip_C_Spine, J_Bip_C_Chest, J_Bip_C_Neck, J_Bip_C_Head, J_Adj_L_FaceEye, J_Sec_Hair1,
    J_Bip_L_Shoulder, J_Bip_L_UpperArm, J_Bip_L_LowerArm, J_Bip_L_Hand, J_Bip_L_Thumb1, J_Bip_L_UpperLeg,
    J_Bip_L_LowerLeg, J_Bip_L_Foot, J_Bip_L_ToeBase
xsens: Pelvis, L5, L3, T12, T8, Neck, Head, LeftShoulder, LeftUpperArm, LeftForeArm, LeftHand, LeftUpperLeg,
    LeftLowerLeg, LeftFoot, LeftToe
smpl: Pelvis, L_Hip, L_Knee, L_Ankle, L_Foot, Spine1, Neck, Head, L_Collar, L_Shoulder, L_Elbow, L_Wrist, L_Hand
    = Pelvis Head L_Collar L_Shoulder L_Elbow L_Wrist L_Hip L_Knee L_Ankle
second_life: mPelvis, mTorso, mChest, mNeck, mHead, mCollarLeft, mShoulderLeft, mElbowLeft, mWristLeft, mHipLeft,
    mKneeLeft, mAnkleLeft, mFootLeft
    = mPelvis mHead mCollarLeft mShoulderLeft mElbowLeft mWristLeft mHipLeft mKneeLeft mAnkleLeft
rigify: DEF-hips, DEF-spine, DEF-neck, DEF-head, DEF-shoulder.L, DEF-upper_arm.L, DEF-upper_arm.L.001, DEF-forearm.L,
    DEF-hand.L, DEF-thigh.L, DEF-shin.L, DEF-foot.L
maya: Root_M, Hip_L, Knee_L, Ankle_L, Spine1_M, Chest_M, Scapula_L, Shoulder_L, Elbow_L, Wrist_L, Neck_M, Head_M
    = Root_M Head_M Scapula_L Shoulder_L Elbow_L Wrist_L Hip_L Knee_L Ankle_L
neuron: Robot_Hips, Robot_Spine, Robot_Neck, Robot_Head, Robot_LeftShoulder, Robot_LeftArm, Robot_LeftForeArm,
    Robot_LeftHand, Robot_LeftUpLeg, Robot_LeftLeg, Robot_LeftFoot
lower: hips, spine, neck, head, leftshoulder, leftarm, leftforearm, lefthand, leftupleg, leftleg, leftfoot, legbone
    = hips head leftshoulder leftarm leftforearm lefthand leftupleg leftleg leftfoot
"""
"""Names of the joints of a convention, and after a sign of equality those of the parts below, where they are typed."""
PARTS = ("hips", "head", "clavicle", "upperarm", "forearm", "hand", "thigh", "shin", "foot")


@pytest.mark.parametrize("convention", CONVENTIONS.strip().replace("\n    ", " ").split("\n"))
def test_every_part_is_found_in_every_convention(convention):
    joints, _, expected = convention.partition(": ")[2].partition(" = ")
    names = tuple(joints.split(", "))
    roles = find_roles(names)
    found = [names[roles[Role(part, "" if part in ("hips", "head") else "left")][0]] for part in PARTS]
    assert not expected or found == expected.split()
    assert Role("spine") in roles and Role("neck") in roles


@pytest.mark.parametrize("change", [str.lower, str.upper, lambda name: name.replace("Left", "Left_")])
def test_case_and_punctuation_do_not_matter(change):
    names = ("Hips", "Left_Arm", "Left_Hand", "Head")
    assert find_roles(tuple(change(name) for name in names)) == find_roles(names)


def test_fingers_toes_and_eyes_play_no_part():
    roles = find_roles(("LeftHandIndex1", "lThumb1", "leftEye", "LHipJoint", "LeftToeBase", "RightHandEnd", "jaw"))
    assert roles == {}


@pytest.mark.parametrize(
    ("name", "plain"),
    [
        ("LThumb", ("thumb", "left")),
        ("upperarm01.R", ("upperarm", "right")),
        ("rShldr", ("shldr", "right")),
        ("Character1:RightUpLeg", ("upleg", "right")),
        ("", ("", "")),
    ],
)
def test_plain_names(name, plain):
    assert plain_names((name, "Hips", "Head"))[0] == plain


@pytest.mark.parametrize(
    ("count", "expected"), [(1, [30]), (2, [10, 30]), (3, [10, 20, 30]), (5, [10, 10, 20, 30, 30])]
)
def test_chains_are_spread_from_first_to_last(count, expected):
    result = spread([10, 20, 30], count)
    assert result[0] == expected[0] and result[-1] == expected[-1] and len(result) == count
    assert result == sorted(result)


def test_a_bust_follows_the_top_of_the_spine():
    bust = find_roles(("chest", "neck", "neck1", "head"))
    performer = find_roles(("Hips", "Spine", "Spine1", "Spine2", "Neck", "Head"))
    assert match_roles(bust, performer) == {0: 3, 1: 4, 2: 4, 3: 5}


def test_the_clip_of_a_bust_moves_the_top_of_a_whole_body():
    body = find_roles(("root", "spine02", "spine01", "neck01", "head"))
    performer = find_roles(("chest", "neck", "head"))
    assert match_roles(body, performer) == {2: 0, 3: 1, 4: 2}
