## 200 bodies fall, roll and sleep: `godot --headless --script fall.gd` prints what was heard, as JSON.
extends SceneTree

const BODIES := 200
const SECONDS := 8.0
const RADIUS := 0.04  # of the score's ball

var scene := CaromScene.new()
var time := 0.0


func _initialize() -> void:
	seed(1)
	scene.listener = Node3D.new()
	scene.listener.position = Vector3(0.0, 1.5, 2.0)
	root.add_child(scene.listener)
	root.add_child(scene)
	var floor_shape := BoxShape3D.new()
	floor_shape.size = Vector3(20.0, 1.0, 20.0)
	add(StaticBody3D.new(), floor_shape, Vector3(0.0, -0.5, 0.0), "ground", 1.0)
	for n in BODIES:
		var ball := SphereShape3D.new()
		var size := 0.6 + 0.01 * (n % 80)
		ball.radius = RADIUS * size
		add(RigidBody3D.new(), ball, Vector3(randf() - 0.5, 0.2 + 2.0 * randf(), randf() - 0.5), "ball", size)


func add(body: PhysicsBody3D, shape: Shape3D, at: Vector3, like: String, size: float) -> void:
	var collision := CollisionShape3D.new()
	collision.shape = shape
	body.position = at
	body.add_child(collision)
	root.add_child(body)
	var sounds := CaromBody.new()
	sounds.like = like
	sounds.size = size
	sounds.scene = scene
	body.add_child(sounds)


func _physics_process(delta: float) -> bool:
	time += delta
	if time > SECONDS:
		print(JSON.stringify(scene.heard().report()))
	return time > SECONDS
