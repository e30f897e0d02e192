"use strict";
// The view of a run in three dimensions: cranes, the payload's trail and target, ground, light, camera.

const TRAIL_COLOR = 0xd9480f, TARGET_COLOR = 0x2a9d5c;
const FIELD = 40; // degrees from top to bottom of the view
const TRAIL_SECONDS = 6;

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
    const box = new THREE.Box3();
    for (const body of this.bodies) body.expand(box);
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
    this.body = new CraneBody(this.scene, this.run.robot, this.frames, this.size);
    this.ghosts = (this.run.ghosts ?? []).map(
      (ghost) => new CraneBody(this.scene, ghost.robot, new Frames(ghost.frames), this.size, ghost.color));
    this.bodies = [this.body, ...this.ghosts];
    this.floor = this.measureFloor();
    this.addGround();
    this.addLights();
    this.addTrail();
    if (this.frames.has("target")) {
      const look = new THREE.MeshLambertMaterial({ color: TARGET_COLOR, transparent: true, opacity: 0.55 });
      this.target = new THREE.Mesh(new THREE.SphereGeometry(0.022 * this.size, 24, 16), look);
      this.scene.add(this.target);
    }
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
    const at = this.frames.locate(t), nodes = this.body.move(t);
    for (const ghost of this.ghosts) ghost.move(t);
    if (this.target) this.target.position.set(...this.frames.at("target", at));
    const since = this.frames.locate(t - TRAIL_SECONDS)[0];
    this.trail.geometry.setDrawRange(since, at[0] - since + 1);
    this.followPayload(new THREE.Vector3(...nodes.slice(-3)));
    this.render();
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

  // Return where a link of a crane is drawn in the world; crane 0 is the run's own, the others are ghosts.
  positionOf(link, crane) {
    this.scene.updateMatrixWorld(true);
    return this.bodies[crane].links[link].getWorldPosition(new THREE.Vector3()).toArray();
  }
}
