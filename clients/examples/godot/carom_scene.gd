## Put one into the scene: it plays the sound, and ends the frames of Godot's physics.
class_name CaromScene
extends AudioStreamPlayer

@export_file("*.carom") var file := "res://scene.carom"
@export_range(0.0, 1.0) var share := 0.15  ## Of a core that the sound may take.
@export var listener: Node3D  ## Where it is heard; else at the camera.

var bodies := {}  # CaromBody by the id of its collider
var opened: CaromStream


## The stream, which is opened when it is first needed.
func heard() -> CaromStream:
	if opened == null:
		opened = CaromStream.new()
		if not opened.open(FileAccess.get_file_as_bytes(file)):
			push_error("Carom: %s: %s" % [file, opened.answer()])
		elif opened.rate() != AudioServer.get_mix_rate():
			push_error("Carom: export with --rate %d" % AudioServer.get_mix_rate())
		expect(opened.govern(share))
	return opened


## Say why a call was refused.
func expect(taken: bool) -> void:
	if not taken:
		push_error("Carom: " + opened.answer())


func _ready() -> void:
	stream = heard()
	play()


func _physics_process(delta: float) -> void:
	for body: CaromBody in bodies.values():
		body.report()
	var ears: Node3D = listener if listener else get_viewport().get_camera_3d()
	if ears:
		expect(heard().listen(ears.global_position, ears.global_basis.x.normalized()))
	expect(heard().frame(delta))
