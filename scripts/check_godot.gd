# Play a Godot animation on a mesh and compare the weights of its shapes with the curves, at every frame.
#
#     godot3-server -s scripts/check_godot.gd --animation=line.tres --take=line.json
#
# line.json is the same animation. The mesh is made here: one triangle, which has the shapes of the curves. It
# is called as the animation calls it. Ends with status 1 for a difference above 1e-5.
extends SceneTree

func _init():
	var animation = load(_given("--animation="))
	var file = File.new()
	file.open(_given("--take="), File.READ)
	var told = JSON.parse(file.get_as_text()).result
	var face = _mesh(told.curves.keys())
	var root_node = Node.new()
	root_node.add_child(face)
	face.name = str(animation.track_get_path(0)).split(":")[0]
	var player = AnimationPlayer.new()
	root_node.add_child(player)
	root.add_child(root_node)
	player.add_animation("line", animation)
	player.play("line")
	var worst = 0.0
	var count = 0
	for frame in range(told.frames):
		player.seek(frame / told.fps, true)
		for name in told.curves:
			if animation.find_track(NodePath(face.name + ":blend_shapes/" + name)) >= 0:
				worst = max(worst, abs(face.get("blend_shapes/" + name) - told.curves[name][frame]))
				count += 1
	print("%d tracks, %d values, largest difference %s" % [animation.get_track_count(), count, str(worst)])
	OS.exit_code = 0 if count > 0 and worst < 1e-5 else 1
	quit()

func _given(option):
	for argument in OS.get_cmdline_args():
		if argument.begins_with(option):
			var path = argument.substr(option.length())
			return path if path.is_abs_path() else OS.get_environment("PWD").plus_file(path)

func _mesh(names):
	var mesh = ArrayMesh.new()
	for name in names:
		mesh.add_blend_shape(name)
	var arrays = []
	arrays.resize(ArrayMesh.ARRAY_MAX)
	arrays[ArrayMesh.ARRAY_VERTEX] = PoolVector3Array([Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0)])
	arrays[ArrayMesh.ARRAY_NORMAL] = PoolVector3Array([Vector3(0, 0, 1), Vector3(0, 0, 1), Vector3(0, 0, 1)])
	var shapes = []
	for name in names:
		shapes.append(arrays.duplicate())
	mesh.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays, shapes)
	var face = MeshInstance.new()
	face.mesh = mesh
	return face
