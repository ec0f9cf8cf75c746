// The scene's own view, by three.js: its surfaces as the engine has read them, and the head in it as
// an arrow that can be dragged. It draws when something has changed, and not otherwise; the eye's
// picture goes before it.

import { Instances } from './instances.js';
import { matrixOf } from './pose.js';

export const MOST_TRIANGLES = 1500000; // what a browser draws without effort
const HEAD = 0xffdc00;
const GRAB_PIXELS = 26;
// A drawing that takes longer than this takes only that share of the time while the eye sees.
const SLOW_MS = 12;
const SHARE = 0.1;
const LOOK_MS = 30; // how often it looks whether its time has come

/** The diagonal of a scene, m; 10 of one that has nothing in it. */
export function sizeOf(bounds) {
  const size = bounds ? Math.hypot(...[0, 1, 2].map((k) => bounds[3 + k] - bounds[k])) : 0;
  return size > 0 ? size : 10;
}

export class SceneView {
  /** three, OrbitControls: of three.js; context: the canvas's WebGL; acts: drag(x, y, z), the head is
   * dragged there; isBusy(), whether the eye's picture is being made. */
  constructor(three, OrbitControls, canvas, context, acts) {
    Object.assign(this, { three, canvas, context, acts });
    this.renderer = new three.WebGLRenderer({ canvas, context, antialias: true });
    this.renderer.gammaOutput = true;
    this.renderer.gammaFactor = 2.2;
    this.scene = new three.Scene();
    this.camera = new three.PerspectiveCamera(55, 2, 0.001, 1000);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableKeys = false;
    this.controls.addEventListener('change', () => this.draw());
    this.head = headOf(three);
    this.scene.add(this.head);
    this.parts = null;
    this.instances = [];
    this.wanted = false;
    this.drawing = false; // until the graphics card has done it
    this.rested = 0; // when it may draw again while the eye sees
    this.#listen();
    new ResizeObserver(() => this.#resize()).observe(canvas.parentElement);
    this.#resize();
  }

  /** Shows another scene; `note` is what it says of what is left out. */
  show({ drawn, bounds_m: bounds, triangles, background }) {
    if (this.parts) {
      this.scene.remove(this.parts);
      this.parts.traverse((each) => {
        each.geometry?.dispose();
        each.material?.map?.dispose();
        each.material?.dispose();
      });
    }
    this.parts = new this.three.Group();
    this.instances = [];
    const images = texturesOf(this.three, drawn.images);
    let number = 0;
    for (const part of drawn.parts) {
      const more = (part.triangles.length / 3) * (part.instances.length / 16);
      if (number + more > MOST_TRIANGLES) continue;
      number += more;
      const instances = instancesOf(this.three, part, images.get(part.image));
      this.instances.push(instances);
      this.parts.add(instances.mesh);
    }
    this.scene.add(this.parts);
    this.scene.background = new this.three.Color(...background).convertLinearToGamma(2.2);
    const size = sizeOf(bounds);
    this.camera.near = 1e-4 * size;
    this.camera.far = 4 * size;
    this.camera.updateProjectionMatrix();
    this.headSize = Math.min(0.05 * size, 0.15);
    this.head.scale.setScalar(this.headSize);
    this.draw();
    const left = triangles - number;
    return left > 0 ? `The view of the scene leaves out ${left.toLocaleString('en')} triangles.` : '';
  }

  /** The camera goes behind, above and to the right of the head. */
  lookAt(pose) {
    const m = matrixOf(pose);
    const far = 6 * this.headSize;
    this.controls.target.set(m[3], m[7], m[11]);
    const at = [m[3], m[7], m[11]].map((middle, k) => (
      middle + far * (0.8 * m[4 * k + 2] + 0.45 * m[4 * k] + (k === 1 ? 0.5 : 0))));
    this.camera.position.set(...at);
    this.controls.update();
    this.draw();
  }

  /** The head is there now; `follows` takes the camera along. */
  place(pose, follows = false) {
    const before = this.head.position.clone();
    this.head.matrixAutoUpdate = true;
    const m = new this.three.Matrix4().set(...matrixOf(pose));
    this.head.position.setFromMatrixPosition(m);
    this.head.quaternion.setFromRotationMatrix(m);
    if (follows) {
      const step = this.head.position.clone().sub(before);
      this.camera.position.add(step);
      this.controls.target.add(step);
      this.controls.update();
    }
    this.draw();
  }

  /** Draws as soon as it may. Without a graphics card a drawing takes the processor from the engine. */
  draw() {
    if (this.wanted) return;
    this.wanted = true;
    if (!this.drawing) requestAnimationFrame(() => this.#drawWhenFree());
  }

  #drawWhenFree() {
    if (!this.wanted) return;
    if (performance.now() < this.rested && this.acts.isBusy()) {
      setTimeout(() => this.#drawWhenFree(), LOOK_MS);
      return;
    }
    this.wanted = false;
    this.drawing = true;
    const before = performance.now();
    this.#leaveOut();
    this.renderer.render(this.scene, this.camera);
    this.#whenDrawn(() => {
      const took = performance.now() - before;
      this.rested = took > SLOW_MS ? before + took / SHARE : 0;
      this.drawing = false;
      if (this.wanted) requestAnimationFrame(() => this.#drawWhenFree());
    });
  }

  #leaveOut() {
    const { three, camera, canvas } = this;
    camera.updateMatrixWorld();
    const seen = new three.Matrix4().getInverse(camera.matrixWorld).premultiply(camera.projectionMatrix);
    const frustum = new three.Frustum().setFromMatrix(seen);
    const pixels = (canvas.height / 2) * camera.projectionMatrix.elements[5];
    for (const each of this.instances) each.see(frustum, camera.position, pixels);
  }

  // Calls of WebGL come back before they are done; WebGL 1 cannot say when they are.
  #whenDrawn(then) {
    const gl = this.context;
    if (!gl.fenceSync) {
      requestAnimationFrame(() => requestAnimationFrame(then));
      return;
    }
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const look = () => {
      if (gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED && !gl.isContextLost()) {
        setTimeout(look, 4);
        return;
      }
      gl.deleteSync(fence);
      then();
    };
    setTimeout(look, 0);
  }

  #resize() {
    const { width, height } = this.canvas.parentElement.getBoundingClientRect();
    if (width < 1 || height < 1) return;
    this.renderer.setPixelRatio(Math.min(globalThis.devicePixelRatio || 1, 2));
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  // The head is dragged in the plane through it that faces the camera. Before OrbitControls, which
  // would turn the camera.
  #listen() {
    const { three, canvas } = this;
    const plane = new three.Plane();
    const caster = new three.Raycaster();
    let holding = null;
    const toRay = (event) => {
      const box = canvas.getBoundingClientRect();
      const x = ((event.clientX - box.left) / box.width) * 2 - 1;
      const y = 1 - ((event.clientY - box.top) / box.height) * 2;
      caster.setFromCamera(new three.Vector2(x, y), this.camera);
      return { x: event.clientX - box.left, y: event.clientY - box.top, box };
    };
    const nearHead = (event) => {
      const { x, y, box } = toRay(event);
      const at = this.head.position.clone().project(this.camera);
      const seen = Math.abs(at.z) < 1;
      const [headX, headY] = [((at.x + 1) / 2) * box.width, ((1 - at.y) / 2) * box.height];
      return seen && Math.hypot(x - headX, y - headY) < GRAB_PIXELS;
    };
    canvas.addEventListener('pointerdown', (event) => {
      if (event.button !== 0 || !nearHead(event)) return;
      const normal = this.camera.getWorldDirection(new three.Vector3());
      plane.setFromNormalAndCoplanarPoint(normal, this.head.position);
      holding = event.pointerId;
      this.controls.enabled = false;
      canvas.setPointerCapture(holding);
    }, true);
    canvas.addEventListener('pointermove', (event) => {
      if (event.pointerId !== holding) {
        canvas.style.cursor = nearHead(event) ? 'grab' : '';
        return;
      }
      toRay(event);
      const place = caster.ray.intersectPlane(plane, new three.Vector3());
      if (place) this.acts.drag(place.x, place.y, place.z);
    }, true);
    for (const name of ['pointerup', 'pointercancel']) {
      canvas.addEventListener(name, (event) => {
        if (event.pointerId !== holding) return;
        holding = null;
        this.controls.enabled = true;
      }, true);
    }
  }
}

// An arrow that points ahead, along -Z, with a fin that says where up is; 1 long.
function headOf(three) {
  const head = new three.Group();
  const material = new three.MeshBasicMaterial({ color: HEAD });
  const dark = new three.MeshBasicMaterial({ color: 0x202020 });
  const cone = new three.Mesh(new three.ConeBufferGeometry(0.22, 0.6, 24), material);
  cone.rotation.x = -Math.PI / 2;
  cone.position.z = -0.45;
  const ball = new three.Mesh(new three.SphereBufferGeometry(0.2, 24, 16), material);
  const fin = new three.Mesh(new three.BoxBufferGeometry(0.04, 0.16, 0.3), dark);
  fin.position.y = 0.22;
  head.add(cone, ball, fin);
  return head;
}

function texturesOf(three, images) {
  const textures = new Map();
  for (const [index, { width, height, pixels }] of images) {
    const texture = new three.DataTexture(pixels, width, height, three.RGBAFormat);
    texture.encoding = three.sRGBEncoding;
    texture.wrapS = three.RepeatWrapping;
    texture.wrapT = three.RepeatWrapping;
    // Pictures of a few pixels are stripes and gratings, whose edges are hard.
    texture.magFilter = width * height <= 64 ? three.NearestFilter : three.LinearFilter;
    texture.minFilter = three.LinearMipmapLinearFilter;
    texture.generateMipmaps = true;
    texture.needsUpdate = true;
    textures.set(index, texture);
  }
  return textures;
}

function instancesOf(three, part, texture) {
  const geometry = new three.BufferGeometry();
  const take = (name, numbers, width) => {
    geometry.setAttribute(name, new three.BufferAttribute(numbers, width));
  };
  take('position', part.positions, 3);
  geometry.setIndex(new three.BufferAttribute(part.triangles, 1));
  if (part.texture_coordinates) take('uv', part.texture_coordinates, 2);
  if (part.colours) take('color', rgbOf(part.colours), 3);
  const material = new three.MeshBasicMaterial({
    color: new three.Color(...part.colour.slice(0, 3)),
    map: part.texture_coordinates && texture ? texture : null,
    side: part.both_sides ? three.DoubleSide : three.FrontSide,
    vertexColors: part.colours ? three.VertexColors : three.NoColors,
    alphaTest: part.alpha === 'mask' ? part.cutoff : 0,
    transparent: part.alpha === 'blend',
    opacity: part.alpha === 'blend' ? part.colour[3] : 1,
  });
  return new Instances(three, geometry, material, part.instances);
}

function rgbOf(rgba) {
  const rgb = new Float32Array((rgba.length / 4) * 3);
  for (let k = 0; k < rgba.length / 4; k += 1) rgb.set(rgba.subarray(4 * k, 4 * k + 3), 3 * k);
  return rgb;
}
