"use strict";
// One crane: solids of the URDF on their joints, ropes between nodes; a ghost has one colour and is seen through.

const Z = new THREE.Vector3(0, 0, 1);
const ROPE_RADIUS = 0.0035; // in sizes of the crane
// Colours of ropes at no tension, at that of the start and at twice as much; one that is slack is thin and orange.
const LOADS = [[0.5, 0.7, 0.87], [0.24, 0.27, 0.31], [0.82, 0.13, 0.13]], SLACK_COLOR = [0.85, 0.45, 0.05];
const GHOST_OPACITY = 0.45;

class CraneBody {
  constructor(scene, robot, frames, size, tint) {
    this.frames = frames;
    this.tint = tint;
    this.base = new THREE.Group();
    scene.add(this.base);
    this.buildRobot(scene, robot);
    this.buildRopes(scene, size);
  }

  buildRobot(scene, robot) {
    const { links, joints } = robot;
    this.links = {};
    for (const [name, solids] of Object.entries(links)) {
      this.links[name] = new THREE.Group();
      for (const solid of solids) this.links[name].add(makeSolid(solid, this.tint));
    }
    const children = new Set(joints.map((joint) => joint.child));
    for (const name of Object.keys(links)) if (!children.has(name)) this.root = this.links[name];
    const moves = this.frames.has("base");
    (moves ? this.base : scene).add(this.root);
    this.joints = joints.map((joint) => this.addJoint(joint));
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

  buildRopes(scene, size) {
    const radius = ROPE_RADIUS * size;
    const rope = () => new THREE.MeshLambertMaterial(this.tint ? { color: this.tint } : {});
    const shape = new THREE.CylinderGeometry(radius, radius, 1, 8).rotateX(Math.PI / 2);
    const falls = this.frames.has("falls");
    const count = falls ? this.frames.parts.falls[1] / 6 : this.frames.parts.nodes[1] / 3 - 1;
    this.ropes = Array.from({ length: count }, () => new THREE.Mesh(shape, rope()));
    for (const each of this.ropes) {
      each.castShadow = true;
      (falls ? this.base : scene).add(each);
    }
  }

  // Take what it covers in its whole run into a box.
  expand(box) {
    box.expandByObject(this.root);
    const { frames } = this, [first, count] = frames.parts.nodes;
    for (let k = 0; k < count; k += 3) {
      const [x, y, z] = [0, 1, 2].map((i) => limits(frames.columns[first + k + i]));
      box.expandByPoint(new THREE.Vector3(x[0], y[0], z[0])).expandByPoint(new THREE.Vector3(x[1], y[1], z[1]));
    }
  }

  // Move it to where it is at time t; return its nodes.
  move(t) {
    const at = this.frames.locate(t), nodes = this.frames.at("nodes", at);
    this.moveJoints(this.frames.at("q", at));
    if (this.frames.has("base")) {
      const [x, y, z, ...turn] = this.frames.at("base", at);
      this.base.position.set(x, y, z);
      this.base.quaternion.set(...turn).normalize();
    }
    this.moveRopes(nodes, at);
    return nodes;
  }

  moveJoints(q) {
    for (const joint of this.joints) {
      const values = joint.places.map((place) => q[place]);
      if (values.length === 4) joint.object.quaternion.set(values[1], values[2], values[3], values[0]).normalize();
      if (values.length !== 1) continue;
      const value = joint.multiplier * values[0] + joint.offset;
      if (joint.prismatic) joint.object.position.copy(joint.axis).multiplyScalar(value);
      else joint.object.quaternion.setFromAxisAngle(joint.axis, value);
    }
  }

  moveRopes(nodes, at) {
    const falls = this.frames.has("falls") ? this.frames.at("falls", at) : null, loads = this.frames.at("tension", at);
    this.ropes.forEach((rope, i) => {
      const ends = falls ? falls.slice(6 * i, 6 * i + 6) : nodes.slice(3 * i, 3 * i + 6);
      const top = new THREE.Vector3(...ends.slice(0, 3)), bottom = new THREE.Vector3(...ends.slice(3));
      const along = bottom.clone().sub(top), length = along.length();
      rope.visible = length > 1e-9;
      rope.position.copy(top).add(bottom).multiplyScalar(0.5);
      rope.quaternion.setFromUnitVectors(Z, along.normalize());
      const load = loads[loads.length === this.ropes.length ? i : 0], thin = load <= 1e-9 ? 0.5 : 1;
      rope.scale.set(thin, thin, Math.max(length, 1e-9));
      if (!this.tint) paintRope(rope.material.color, load);
    });
  }
}

// Give a colour to a rope whose tension is a share `load` of the one at the start.
function paintRope(color, load) {
  const [from, to] = load < 1 ? LOADS : LOADS.slice(1), share = load < 1 ? load : Math.min(load - 1, 1);
  const mixed = load <= 1e-9 ? SLACK_COLOR : from.map((part, i) => part + share * (to[i] - part));
  color.setRGB(...mixed, "srgb");
}

function makeSolid({ size, at, rpy, color }, tint) {
  const [red, green, blue] = color;
  const shape = size.length === 3 ? new THREE.BoxGeometry(...size)
    : size.length === 2 ? new THREE.CylinderGeometry(size[0], size[0], size[1], 32).rotateX(Math.PI / 2)
    : new THREE.SphereGeometry(size[0], 32, 20);
  const look = new THREE.MeshStandardMaterial({ roughness: 0.75, metalness: 0.05 });
  look.color.setRGB(red, green, blue, "srgb");
  if (tint) {
    look.color.set(tint);
    Object.assign(look, { transparent: true, opacity: GHOST_OPACITY });
  }
  const mesh = new THREE.Mesh(shape, look);
  mesh.position.set(...at);
  mesh.rotation.set(...rpy, "ZYX");
  mesh.castShadow = mesh.receiveShadow = !tint;
  return mesh;
}
