// Bodies fall into a pit, roll and sleep: shown by three.js, moved by cannon-es, heard by Carom.

import * as CANNON from "cannon-es";
import * as THREE from "three";
import { Carom } from "./OUT/carom.js";
import { Heard } from "./bodies.js";

const STEP = 1 / 60;
const COUNT = Number(new URLSearchParams(location.search).get("bodies") ?? 200);
const KINDS = [
  { like: "ball", shape: (s) => new CANNON.Sphere(0.04 * s), mesh: (s) => new THREE.SphereGeometry(0.04 * s), mass: 2.1 },
  { like: "crate", shape: (s) => new CANNON.Box(new CANNON.Vec3(0.06, 0.05, 0.04).scale(s)), mesh: (s) => new THREE.BoxGeometry(0.12 * s, 0.1 * s, 0.08 * s), mass: 0.67 },
];

const world = new CANNON.World({ gravity: new CANNON.Vec3(0, 0, -9.81), allowSleep: true });
world.broadphase = new CANNON.SAPBroadphase(world);
world.defaultContactMaterial.restitution = 0.4;
world.solver.iterations = 6;

const shown = new THREE.Scene();
const camera = new THREE.PerspectiveCamera(50, innerWidth / innerHeight, 0.1, 50);
camera.up.set(0, 0, 1);
camera.position.set(0, -3.5, 2);
camera.lookAt(0, 0, 0.2);
shown.add(new THREE.HemisphereLight(0xffffff, 0x334455, 3));
const renderer = new THREE.WebGLRenderer();
renderer.setSize(innerWidth, innerHeight);
document.body.append(renderer.domElement);

function fixed(turn, place) {
  const body = new CANNON.Body({ mass: 0, shape: new CANNON.Plane() });
  body.quaternion.setFromVectors(new CANNON.Vec3(0, 0, 1), turn);
  body.position.copy(place);
  world.addBody(body);
  return body;
}

/** Let so many bodies fall; what is heard of them. */
export async function drop(count = COUNT) {
  const context = new AudioContext({ sampleRate: 48000 });
  const carom = await Carom.open(context, { folder: new URL("./OUT/", import.meta.url) });
  await context.resume();
  const heard = new Heard(world, carom);
  carom.govern(0.25);
  carom.listen(camera.position.toArray(), [1, 0, 0]);
  heard.add(fixed(new CANNON.Vec3(0, 0, 1), new CANNON.Vec3()), "ground");
  for (const [x, y] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) fixed(new CANNON.Vec3(-x, -y, 0), new CANNON.Vec3(x, y, 0));
  const pairs = [];
  for (let n = 0; n < count; n++) {
    const kind = KINDS[n % KINDS.length];
    const size = 0.7 + 0.6 * Math.random();
    const body = new CANNON.Body({ mass: kind.mass * size ** 3, shape: kind.shape(size), angularDamping: 0.05, sleepSpeedLimit: 0.1, sleepTimeLimit: 0.5 });
    body.position.set(1.6 * (Math.random() - 0.5), 1.6 * (Math.random() - 0.5), 0.2 + (2 * n) / count);
    body.velocity.set(Math.random() - 0.5, Math.random() - 0.5, 0);
    world.addBody(body);
    const mesh = new THREE.Mesh(kind.mesh(size), new THREE.MeshStandardMaterial({ color: 0xffffff * Math.random() }));
    shown.add(mesh);
    pairs.push([body, mesh]);
    await heard.add(body, kind.like, { size, material: n % 4 ? undefined : "glass" });
  }
  let last = performance.now(), left = 0;
  const draw = (now) => {
    left = Math.min(left + (now - last) / 1000, 4 * STEP);
    for (last = now; left >= STEP; left -= STEP) world.step(STEP);
    for (const [body, mesh] of pairs) {
      mesh.position.copy(body.position);
      mesh.quaternion.copy(body.quaternion);
    }
    renderer.render(shown, camera);
    requestAnimationFrame(draw);
  };
  requestAnimationFrame(draw);
  return { carom, world, context };
}

document.querySelector("button").onclick = ({ target }) => {
  target.remove();
  drop();
};
