// What the page needs of three.js; bundle_three.sh makes three.min.js of it.
export {
  Box3, BoxGeometry, BufferAttribute, BufferGeometry, CylinderGeometry, DirectionalLight,
  Group, HemisphereLight, Line, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial,
  MeshStandardMaterial, PerspectiveCamera, PlaneGeometry, Scene,
  SphereGeometry, Vector3, WebGLRenderer,
} from "three";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
