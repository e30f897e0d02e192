"use strict";
// The crane in three dimensions: solids of the URDF on their joints, ropes between nodes, load, target, ground.

const Z = new THREE.Vector3(0, 0, 1);
const ROPE_COLOR = 0x3c4650, TRAIL_COLOR = 0xd9480f, TARGET_COLOR = 0x2a9d5c;
const FIELD = 40; // degrees from top to bottom of the view
const TRAIL_SECONDS = 6, ROPE_RADIUS = 0.0035; // radius in sizes of the crane

class CraneView {
  constructor(canvas, run, frames) {
    this.canvas = canvas;
    this.run = run;
    this.frames = frames;
    this.size = run.framing.size;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.buildScene();
    this.camera = new THREE.PerspectiveCamera(FIELD, 1, 0.002 * this.size, 400 * this.size);
    this.camera.up.copy(Z);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.render());
    this.controls.addEventListener("start", () => (this.turned = true)); // a person chose another view
    this.following = Boolean(run.framing.follows);
    this.resetView();
  }

  // Return the middle and half the edge of the ground: what the recording says, and below all of the crane.
  measureFloor() {
    const { ground, ground_size } = this.run.framing, { middle, listed } = this.corners();
    const reach = Math.max(...listed.flatMap((corner) => [Math.abs(corner.x), Math.abs(corner.y)]));
    const wide = 1.15 * reach > ground_size;
    return { at: wide ? [middle.x, middle.y, ground[2]] : ground, half: Math.ceil(wide ? 1.25 * reach : ground_size) };
  }

  // Return the corners of what the whole run takes, from the middle between them.
  corners() {
    const box = new THREE.Box3().setFromObject(this.root), { frames } = this, [first, count] = frames.parts.nodes;
    for (let k = 0; k < count; k += 3) {
      const [x, y, z] = [0, 1, 2].map((i) => limits(frames.columns[first + k + i]));
      box.expandByPoint(new THREE.Vector3(x[0], y[0], z[0])).expandByPoint(new THREE.Vector3(x[1], y[1], z[1]));
    }
    const middle = box.getCenter(new THREE.Vector3());
    box.expandByPoint(new THREE.Vector3(middle.x, middle.y, this.run.framing.ground[2]));
    box.getCenter(middle);
    const ends = [box.min, box.max], listed = [];
    for (const a of ends) for (const b of ends) for (const c of ends) listed.push(new THREE.Vector3(a.x, b.y, c.z).sub(middle));
    return { middle, listed };
  }

  // Look at the whole run from the recording's side, as near as its corners allow.
  fitView() {
    const { eye, look_at } = this.run.framing, { middle, listed } = this.corners();
    const out = new THREE.Vector3(...eye).sub(new THREE.Vector3(...look_at)).normalize();
    const right = new THREE.Vector3().crossVectors(Z, out).normalize(), up = new THREE.Vector3().crossVectors(out, right);
    const slope = 0.92 * Math.tan(0.5 * FIELD * Math.PI / 180);
    const needs = listed.map((corner) => corner.dot(out) + Math.max(
      Math.abs(corner.dot(right)) / (slope * this.camera.aspect), Math.abs(corner.dot(up)) / slope));
    this.camera.position.copy(middle).addScaledVector(out, Math.max(...needs));
    this.controls.target.copy(middle);
  }

  buildScene() {
    this.scene = new THREE.Scene();
    this.base = new THREE.Group();
    this.scene.add(this.base);
    this.buildRobot();
    this.floor = this.measureFloor();
    this.addGround();
    this.addLights();
    const radius = ROPE_RADIUS * this.size;
    const rope = new THREE.MeshLambertMaterial({ color: ROPE_COLOR });
    const shape = new THREE.CylinderGeometry(radius, radius, 1, 8).rotateX(Math.PI / 2);
    const falls = this.frames.has("falls");
    const count = falls ? this.frames.parts.falls[1] / 6 : this.frames.parts.nodes[1] / 3 - 1;
    this.ropes = Array.from({ length: count }, () => new THREE.Mesh(shape, rope));
    for (const each of this.ropes) {
      each.castShadow = true;
      (falls ? this.base : this.scene).add(each);
    }
    this.addTrail();
    if (this.frames.has("target")) {
      const look = new THREE.MeshLambertMaterial({ color: TARGET_COLOR, transparent: true, opacity: 0.55 });
      this.target = new THREE.Mesh(new THREE.SphereGeometry(0.022 * this.size, 24, 16), look);
      this.scene.add(this.target);
    }
  }

  buildRobot() {
    const { links, joints } = this.run.robot;
    this.links = {};
    for (const [name, solids] of Object.entries(links)) {
      this.links[name] = new THREE.Group();
      for (const solid of solids) this.links[name].add(makeSolid(solid));
    }
    const children = new Set(joints.map((joint) => joint.child));
    for (const name of Object.keys(links)) if (!children.has(name)) this.root = this.links[name];
    const moves = this.frames.has("base");
    (moves ? this.base : this.scene).add(this.root);
    this.joints = joints.map((joint) => this.addJoint(joint));
    if (!moves) this.scene.add(this.base);
  }

  addJoint(joint) {
    const mount = new THREE.Group(), child = this.links[joint.child];
    mount.position.set(...joint.at);
    mount.rotation.set(...joint.rpy, "ZYX");
    mount.add(child);
    this.links[joint.parent].add(mount);
    const axis = joint.axis ? new THREE.Vector3(...joint.axis) : null;
    const places = [joint.source ?? []].flat().map((i) => this.frames.moving.indexOf(i));
    return { ...joint, axis, places, object: child };
  }

  addGround() {
    const { at: ground, half } = this.floor;
    const color = this.run.afloat ? 0xa9c6d8 : 0xd7dbdd;
    const plane = new THREE.Mesh(new THREE.PlaneGeometry(2 * half, 2 * half), new THREE.MeshLambertMaterial({ color }));
    plane.position.set(...ground);
    plane.receiveShadow = true;
    const pitch = 10 ** Math.max(0, Math.ceil(Math.log10(half / 40))), points = [];
    for (let i = -half; i <= half; i += pitch) points.push(i, -half, 0, i, half, 0, -half, i, 0, half, i, 0);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points), 3));
    const look = new THREE.LineBasicMaterial({ color: 0x8b98a5, transparent: true, opacity: 0.55 });
    const grid = new THREE.LineSegments(geometry, look);
    grid.position.set(ground[0], ground[1], ground[2] + 0.002 * this.size);
    this.scene.add(plane, grid);
  }

  addLights() {
    const { at: ground, half } = this.floor, reach = 1.3 * half;
    const sky = new THREE.HemisphereLight(0xffffff, 0x9aa5ae, 1.9);
    sky.position.set(0, 0, 1);
    const sun = new THREE.DirectionalLight(0xffffff, 2.2);
    sun.position.set(ground[0] - 0.5 * reach, ground[1] - 0.9 * reach, ground[2] + 2 * reach);
    sun.target.position.set(...ground);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    Object.assign(sun.shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach, near: 0.01, far: 6 * reach });
    sun.shadow.normalBias = 0.002 * this.size;
    this.scene.add(sky, sun, sun.target);
  }

  addTrail() {
    const { frames } = this, [first, count] = frames.parts.nodes;
    const xyz = [0, 1, 2].map((i) => frames.columns[first + count - 3 + i]);
    const points = new Float32Array(3 * frames.t.length);
    for (let i = 0; i < frames.t.length; i++) for (let k = 0; k < 3; k++) points[3 * i + k] = xyz[k][i];
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
    this.trail = new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: TRAIL_COLOR }));
    this.trail.frustumCulled = false;
    this.scene.add(this.trail);
  }

  // Move everything to where it is at time t.
  move(t) {
    const at = this.frames.locate(t);
    this.moveJoints(this.frames.at("q", at));
    if (this.frames.has("base")) {
      const [x, y, z, ...turn] = this.frames.at("base", at);
      this.base.position.set(x, y, z);
      this.base.quaternion.set(...turn).normalize();
    }
    const nodes = this.frames.at("nodes", at);
    this.moveRopes(nodes, at);
    if (this.target) this.target.position.set(...this.frames.at("target", at));
    const since = this.frames.locate(t - TRAIL_SECONDS)[0];
    this.trail.geometry.setDrawRange(since, at[0] - since + 1);
    this.followPayload(new THREE.Vector3(...nodes.slice(-3)));
    this.render();
  }

  moveJoints(q) {
    for (const joint of this.joints) {
      const values = joint.places.map((place) => q[place]);
      if (values.length === 4) joint.object.quaternion.set(values[1], values[2], values[3], values[0]).normalize();
      if (values.length !== 1) continue;
      const value = joint.multiplier * values[0] + joint.offset;
      if (joint.slides) joint.object.position.copy(joint.axis).multiplyScalar(value);
      else joint.object.quaternion.setFromAxisAngle(joint.axis, value);
    }
  }

  moveRopes(nodes, at) {
    const falls = this.frames.has("falls") ? this.frames.at("falls", at) : null;
    this.ropes.forEach((rope, i) => {
      const ends = falls ? falls.slice(6 * i, 6 * i + 6) : nodes.slice(3 * i, 3 * i + 6);
      const top = new THREE.Vector3(...ends.slice(0, 3)), bottom = new THREE.Vector3(...ends.slice(3));
      const along = bottom.clone().sub(top), length = along.length();
      rope.visible = length > 1e-9;
      rope.position.copy(top).add(bottom).multiplyScalar(0.5);
      rope.quaternion.setFromUnitVectors(Z, along.normalize());
      rope.scale.set(1, 1, Math.max(length, 1e-9));
    });
  }

  followPayload(payload) {
    if (this.following && this.payload) {
      const step = payload.clone().sub(this.payload);
      this.camera.position.add(step);
      this.controls.target.add(step);
      this.controls.update();
    }
    this.payload = payload;
  }

  resetView() {
    const { eye, look_at, follows } = this.run.framing;
    this.payload = null;
    this.turned = false;
    this.camera.position.set(...eye);
    this.controls.target.set(...look_at);
    if (!follows) this.fitView();
    this.controls.update();
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    if (!this.turned && !this.following) this.resetView();
    this.render();
  }

  render() {
    this.renderer.render(this.scene, this.camera);
  }

  // Return where a link is drawn in the world.
  positionOf(link) {
    this.scene.updateMatrixWorld(true);
    return this.links[link].getWorldPosition(new THREE.Vector3()).toArray();
  }
}

function makeSolid({ size, at, rpy, color }) {
  const [red, green, blue] = color;
  const shape = size.length === 3 ? new THREE.BoxGeometry(...size)
    : size.length === 2 ? new THREE.CylinderGeometry(size[0], size[0], size[1], 32).rotateX(Math.PI / 2)
    : new THREE.SphereGeometry(size[0], 32, 20);
  const look = new THREE.MeshStandardMaterial({ roughness: 0.75, metalness: 0.05 });
  look.color.setRGB(red, green, blue, "srgb");
  const mesh = new THREE.Mesh(shape, look);
  mesh.position.set(...at);
  mesh.rotation.set(...rpy, "ZYX");
  mesh.castShadow = mesh.receiveShadow = true;
  return mesh;
}
