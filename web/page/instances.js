// Instances of a mesh for three.js, of which only those are drawn that the camera sees: a scene stands
// all around the head, and without a graphics card its corners are what a drawing takes.

const LEAST_PIXELS = 0.5; // radius of what is still drawn

/** places: world_from_mesh of each instance, 16 numbers, row by row. */
export class Instances {
  constructor(three, geometry, material, places) {
    const number = places.length / 16;
    this.mesh = new three.InstancedMesh(geometry, material, number);
    this.mesh.frustumCulled = false; // its instances lie all over the scene
    this.matrices = new Float32Array(16 * number); // column by column
    this.spheres = [];
    geometry.computeBoundingSphere();
    const place = new three.Matrix4();
    for (let k = 0; k < number; k += 1) {
      place.set(...places.subarray(16 * k, 16 * k + 16));
      place.toArray(this.matrices, 16 * k);
      this.spheres.push(geometry.boundingSphere.clone().applyMatrix4(place));
    }
    this.mesh.instanceMatrix.setUsage?.(three.DynamicDrawUsage);
  }

  /** Leaves what is in a frustum and not too small. pixels: how many a radius of 1 has at distance 1
   * from `eye`. */
  see(frustum, eye, pixels) {
    const { mesh, matrices, spheres } = this;
    let seen = 0;
    for (let k = 0; k < spheres.length; k += 1) {
      const { center, radius } = spheres[k];
      const isLarge = radius * pixels > LEAST_PIXELS * eye.distanceTo(center);
      if (isLarge && frustum.intersectsSphere(spheres[k])) {
        mesh.instanceMatrix.array.set(matrices.subarray(16 * k, 16 * k + 16), 16 * seen);
        seen += 1;
      }
    }
    mesh.count = seen;
    mesh.visible = seen > 0;
    mesh.instanceMatrix.needsUpdate = true;
  }
}
