// Bodies of cannon-es, heard by a scene that Carom has exported.

const SLEEPY = 1; // of CANNON.Body's sleepStates: what is above sleeps

const list = ({ x, y, z }) => [x, y, z];

export class Heard {
  /** world: of cannon-es; carom: an opened Carom. */
  constructor(world, carom) {
    Object.assign(this, { world, carom, names: new Map(), velocities: new Map(), made: 0 });
    world.addEventListener("postStep", () => this.report());
  }

  /** Have a body heard as one of the score; a copy of it, in another size or of another material, if it moves. */
  add(body, like, { size = 1, material } = {}) {
    const moves = body.mass > 0;
    const name = moves ? `${like}.${++this.made}` : like;
    this.names.set(body.id, name);
    if (moves) return this.carom.send("/object/new", name, like, "size", size, ...(material ? ["material", material] : []));
    this.carom.move(name, list(body.position));
    return Promise.resolve();
  }

  remove(body) {
    const name = this.names.get(body.id);
    this.names.delete(body.id);
    return body.mass > 0 ? this.carom.send(`/object/${name}/free`) : Promise.resolve();
  }

  /** The velocity of a point of a body before the step, which says how fast bodies meet in it. */
  velocityAt(body, arm) {
    const [velocity, spin] = this.velocities.get(body.id) ?? [body.velocity, body.angularVelocity];
    return spin.cross(arm).vadd(velocity);
  }

  /** Report a step. */
  report() {
    const { carom, names, world } = this;
    for (const body of world.bodies) {
      if (!names.has(body.id) || body.mass === 0 || body.sleepState > SLEEPY) continue;
      const { position, quaternion: { w, x, y, z }, velocity, angularVelocity } = body;
      carom.move(names.get(body.id), list(position), [w, x, y, z], list(velocity), list(angularVelocity));
    }
    for (const { bi, bj, ni, ri, rj } of world.contacts) { // ni leads from bi to bj
      const [a, b] = [names.get(bi.id), names.get(bj.id)];
      if (a === undefined || b === undefined || (bi.sleepState > SLEEPY && bj.sleepState > SLEEPY)) continue;
      const speed = this.velocityAt(bi, ri).vsub(this.velocityAt(bj, rj)).dot(ni);
      carom.touch(a, b, list(bi.position.vadd(ri)), list(ni.unit()), { speed });
    }
    this.velocities = new Map(world.bodies.map((body) => [body.id, [body.velocity.clone(), body.angularVelocity.clone()]]));
    return carom.frame(world.dt).catch((error) => console.error(error.message));
  }
}
