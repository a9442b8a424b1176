// What the page's view AR uses of three.js: all that gets into the bundle.
export {
  AmbientLight, Box3, BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, Group, HemisphereLight, LinearFilter, Matrix4, Mesh, MeshBasicMaterial,
  MeshStandardMaterial, NoColorSpace, OrthographicCamera, PerspectiveCamera, SRGBColorSpace, Scene, ShaderMaterial, Texture, TextureLoader, Vector3, WebGLRenderer, WebGLRenderTarget,
} from "three";
export { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
