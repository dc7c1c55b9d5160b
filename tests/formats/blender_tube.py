"""A tube with two bones, as lines of Python for Blender: what the tests of several formats bend."""

TUBE = """
bpy.ops.mesh.primitive_cylinder_add(vertices=8, radius=0.2, depth=2, location=(0, 0, 1), end_fill_type="TRIFAN")
tube = bpy.context.object
bpy.ops.object.transform_apply(location=True)
bpy.ops.object.mode_set(mode="EDIT")
bpy.ops.mesh.subdivide(number_cuts=2)
bpy.ops.object.mode_set(mode="OBJECT")
"""
"""Makes `tube`, of the scene of `bpy`."""

RIG = """
bpy.ops.object.armature_add()
rig = bpy.context.object
bpy.ops.object.mode_set(mode="EDIT")
upper = rig.data.edit_bones[0]
upper.name, upper.head, upper.tail = "upper", (0, 0, 0), (0, 0, 1)
lower = rig.data.edit_bones.new("lower")
lower.head, lower.tail, lower.parent = (0, 0, 1), (0, 0, 2), upper
bpy.ops.object.mode_set(mode="OBJECT")
for name in ("upper", "lower"):
    tube.vertex_groups.new(name=name)
for vertex in tube.data.vertices:
    share = min(max(vertex.co.z - 0.5, 0.0), 1.0)
    tube.vertex_groups["upper"].add([vertex.index], 1.0 - share, "REPLACE")
    tube.vertex_groups["lower"].add([vertex.index], share, "REPLACE")
tube.parent = rig
tube.modifiers.new("skin", "ARMATURE").object = rig
for bone in rig.pose.bones:
    bone.rotation_mode = "XYZ"
def bend(frame, lower, upper):
    rig.pose.bones["lower"].rotation_euler.x = lower * frame
    rig.pose.bones["upper"].rotation_euler.y = upper * frame
    rig.pose.bones["upper"].location.x = 0.04 * frame
    for bone in rig.pose.bones:
        bone.keyframe_insert("rotation_euler", frame=frame)
        bone.keyframe_insert("location", frame=frame)
def shown_at(frames):
    points = []
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        seen = tube.evaluated_get(bpy.context.evaluated_depsgraph_get())
        points.append([seen.matrix_world @ vertex.co for vertex in seen.data.vertices])
    return points
"""
"""Makes `rig`, which moves it: `bend` sets its keys at a frame [rad a frame], `shown_at` gives the points at frames."""
