## Put one below a RigidBody3D, a StaticBody3D or another collider: what it sounds like.
class_name CaromBody
extends Node

const CONTACTS := 8  # of a body that Godot reports: what is left out is not heard

static var made := 0

@export var like := "crate"  ## A body of the score.
@export var size := 1.0  ## In times that body's.
@export var material := ""  ## Empty: that body's.
@export var scene: CaromScene

var number := -1
var own := ""  # the name of a copy
var collider: CollisionObject3D


func _enter_tree() -> void:
	collider = get_parent()
	if collider is RigidBody3D:
		made += 1
		own = "%s.%d" % [like, made]
		var of := " material " + material if material else ""
		scene.expect(scene.heard().send("/object/new %s %s size %s%s" % [own, like, size, of]))
		number = scene.heard().body(own)
		collider.contact_monitor = true
		collider.max_contacts_reported = CONTACTS
	else:  # it is held: the score's
		number = scene.heard().body(like)
		var turn := collider.global_basis.get_rotation_quaternion()
		scene.expect(scene.heard().move(number, collider.global_position, turn, Vector3.ZERO, Vector3.ZERO))
	scene.bodies[collider.get_instance_id()] = self


func _exit_tree() -> void:
	scene.bodies.erase(collider.get_instance_id())
	if own:
		scene.expect(scene.heard().send("/object/%s/free" % own))


func sleeps() -> bool:
	return collider is RigidBody3D and collider.sleeping


## Report the last step of Godot's physics.
func report() -> void:
	if not collider is RigidBody3D or sleeps():
		return
	var state := PhysicsServer3D.body_get_direct_state(collider.get_rid())
	var turn := state.transform.basis.get_rotation_quaternion()
	var centre := state.transform.origin + state.center_of_mass
	scene.expect(scene.heard().move(number, centre, turn, state.linear_velocity, state.angular_velocity))
	for n in state.get_contact_count():
		var other: CaromBody = scene.bodies.get(state.get_contact_collider_id(n))
		# Both bodies of a pair are asked: the one of the higher number reports it.
		if other == null or (other.number > number and not other.sleeps()):
			continue
		var normal := state.get_contact_local_normal(n)  # it leads from the other to this
		var own_velocity := state.get_contact_local_velocity_at_position(n)  # before they met
		var speed := (state.get_contact_collider_velocity_at_position(n) - own_velocity).dot(normal)
		var point := state.get_contact_local_position(n)
		scene.expect(scene.heard().touch(other.number, number, point, normal, NAN, speed, NAN))
