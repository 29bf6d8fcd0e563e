/** Vertices and triangles whose number is known afterwards. */

export class Growing {
  positions: Float32Array;
  /** Not of length 1 yet. */
  normals: Float32Array;
  indices: Uint32Array;
  nVertices = 0;
  nIndices = 0;

  constructor(triangles: number) {
    const vertices = Math.ceil(0.55 * triangles) + 64; // of a closed surface half as many as triangles
    this.positions = new Float32Array(3 * vertices);
    this.normals = new Float32Array(3 * vertices);
    this.indices = new Uint32Array(3 * triangles);
  }

  vertex(x: number, y: number, z: number): number {
    const at = 3 * this.nVertices;
    if (at + 3 > this.positions.length) {
      this.positions = enlarged(this.positions);
      this.normals = enlarged(this.normals);
    }
    this.positions[at] = x;
    this.positions[at + 1] = y;
    this.positions[at + 2] = z;
    return this.nVertices++;
  }

  turn(vertex: number, x: number, y: number, z: number): void {
    this.normals[3 * vertex]! += x;
    this.normals[3 * vertex + 1]! += y;
    this.normals[3 * vertex + 2]! += z;
  }

  triangle(a: number, b: number, c: number): void {
    if (this.nIndices + 3 > this.indices.length) {
      const more = new Uint32Array(2 * this.indices.length + 3);
      more.set(this.indices);
      this.indices = more;
    }
    this.indices[this.nIndices++] = a;
    this.indices[this.nIndices++] = b;
    this.indices[this.nIndices++] = c;
  }

  finish(): { positions: Float32Array; normals: Int16Array; indices: Uint32Array } {
    const normals = new Int16Array(4 * this.nVertices);
    for (let i = 0; i < this.nVertices; i++) {
      const x = this.normals[3 * i]!;
      const y = this.normals[3 * i + 1]!;
      const z = this.normals[3 * i + 2]!;
      const length = Math.hypot(x, y, z) || 1;
      normals[4 * i] = Math.round((32767 * x) / length);
      normals[4 * i + 1] = Math.round((32767 * y) / length);
      normals[4 * i + 2] = Math.round((32767 * z) / length);
    }
    return { positions: this.positions.slice(0, 3 * this.nVertices), normals, indices: this.indices.slice(0, this.nIndices) };
  }
}

function enlarged(old: Float32Array): Float32Array {
  const more = new Float32Array(2 * old.length);
  more.set(old);
  return more;
}
