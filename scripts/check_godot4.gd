# Play a Godot animation on the character that it was written for, in Godot 4, and compare it with the GLB.
#
#     godot --headless -s scripts/check_godot4.gd -- --scene=line.glb --animation=line.tres
#
# Both files are of the same `phonanim animate --character mine.glb --key-tolerance 0 -o line.tres -o line.glb`.
# Every track must find its mesh or bone, and every weight and rotation must be that of the animation in the
# GLB, at every frame. Ends with status 1 for a track that finds nothing or a difference above 1e-5.
extends SceneTree

func _initialize():
	var document := GLTFDocument.new()
	var state := GLTFState.new()
	state.handle_binary_image_mode = GLTFState.HANDLE_BINARY_IMAGE_MODE_DISCARD_TEXTURES
	if document.append_from_file(_given("--scene="), state) != OK:
		quit(1)
		return
	var scene := document.generate_scene(state)
	root.add_child(scene)
	var player: AnimationPlayer = scene.find_children("*", "AnimationPlayer", true, false)[0]
	var names := player.get_animation_list()
	var theirs: Animation = player.get_animation(names[names.size() - 1])
	var ours: Animation = load(_given("--animation="))
	var worst := 0.0
	var count := 0
	var lost := 0
	for track in ours.get_track_count():
		var path := ours.track_get_path(track)
		var other := theirs.find_track(_as_imported(path), _kind(ours, track))
		if other < 0 or scene.get_node_or_null(NodePath(path.get_concatenated_names())) == null:
			print("nothing at ", path)
			lost += 1
			continue
		for key in theirs.track_get_key_count(other):
			var time := theirs.track_get_key_time(other, key)
			worst = maxf(worst, _difference(ours, track, theirs, other, time))
			count += 1
	print("%d tracks, %d without a place, %d values, largest difference %s" % [
		ours.get_track_count(), lost, count, worst])
	quit(0 if lost == 0 and count > 0 and worst < 1e-5 else 1)

func _difference(ours: Animation, track: int, theirs: Animation, other: int, time: float) -> float:
	if ours.track_get_type(track) == Animation.TYPE_ROTATION_3D:
		var one := ours.rotation_track_interpolate(track, time)
		var two := theirs.rotation_track_interpolate(other, time)
		return 1.0 - absf(one.dot(two))
	return absf(ours.value_track_interpolate(track, time) - theirs.blend_shape_track_interpolate(other, time))

# The importer writes Head:jawOpen for the property Head:blend_shapes/jawOpen.
func _as_imported(path: NodePath) -> NodePath:
	return NodePath(str(path).replace(":blend_shapes/", ":"))

func _kind(animation: Animation, track: int) -> int:
	var kind := animation.track_get_type(track)
	return kind if kind == Animation.TYPE_ROTATION_3D else Animation.TYPE_BLEND_SHAPE

func _given(option: String) -> String:
	for argument in OS.get_cmdline_user_args():
		if argument.begins_with(option):
			var path := argument.substr(option.length())
			return path if path.is_absolute_path() else OS.get_environment("PWD").path_join(path)
	return ""
