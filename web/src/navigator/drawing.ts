/**
 * The World drawn by the browser's graphics card, through three.js. A module of its own, drawing.js, which the page
 * fetches when it draws itself for the first time.
 *
 * Solids that planes cut show a face there. Its pixels are those whose rays go through the closed surface an odd number
 * of times behind the planes; the stencil counts, one volume after the other, before any surface is drawn.
 */
import * as three from "three";
import { composed, covectors, depthsOf, isMirrored, lensOf, projection, seenFrom, seenPlane, toEye, turned, type Lens, type View } from "./lens";
import { countFragment, faceFragment, faceVertex, surfaceFragment, surfaceVertex } from "./shaders";
import type { Shape, ShapePart } from "./shape";
import type { Surface } from "./surface";

export interface DrawnPart {
  part: ShapePart;
  surface: Surface;
}

type Uniforms = { [name: string]: three.Uniform };

const KINDS = { directional: 0, point: 1, spot: 2 };
const SHADINGS = { none: 0, phong: 1, blinn: 2 };
const SURFACES_LAST = 1e6; // in the order of drawing

const encoded = (v: number): number => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);

/** One part with its buffers; the map from its numbers to the World. */
interface Placed {
  part: ShapePart;
  surface: Surface;
  map: number[];
  uniforms: Uniforms;
  count: three.Mesh | null;
  material: three.RawShaderMaterial;
  /** That is seen of a solid which nothing cuts. */
  outside: number;
}

/** The cut face of one volume. */
interface Face {
  parts: Placed[];
  mesh: three.Mesh;
}

export class Drawing {
  private renderer: three.WebGLRenderer;
  private scene = new three.Scene();
  private camera = new three.Camera();
  private geometries = new Map<Surface, three.BufferGeometry>();
  private materials: three.RawShaderMaterial[] = [];
  private placed: Placed[] = [];
  private faces: Face[] = [];
  private shape: Shape | null = null;
  private common: Uniforms = { clip: { value: null }, parallel_: { value: false }, half_: { value: [1, 1] } };
  private light: Uniforms = {};
  private everything: three.BufferGeometry;

  /** Throws where the browser has no WebGL 2. */
  constructor(private canvas: HTMLCanvasElement) {
    three.ColorManagement.enabled = false; // colours are what the shaders make of them
    this.renderer = new three.WebGLRenderer({ canvas, antialias: true, alpha: true, stencil: true, powerPreference: "high-performance" });
    this.renderer.outputColorSpace = three.LinearSRGBColorSpace;
    const corners = new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]);
    this.everything = new three.BufferGeometry().setAttribute("position", new three.BufferAttribute(corners, 3));
  }

  /** Nothing happens where it has that size. */
  resize(width: number, height: number): void {
    if (this.canvas.width === width && this.canvas.height === height) return;
    this.renderer.setSize(width, height, false);
  }

  dispose(): void {
    this.forget();
    for (const geometry of this.geometries.values()) geometry.dispose();
    this.everything.dispose();
    this.renderer.dispose();
  }

  /** What is drawn from now on. Surfaces that were there before keep their buffers. */
  setShape(shape: Shape, parts: DrawnPart[]): void {
    this.forget();
    this.shape = shape;
    this.setLight(shape);
    const drawn = new Set(parts.map(({ surface }) => surface));
    for (const [surface, geometry] of this.geometries)
      if (!drawn.has(surface)) {
        geometry.dispose();
        this.geometries.delete(surface);
      }
    for (const part of parts) this.add(part);
    this.addFaces();
  }

  private forget(): void {
    this.scene.clear();
    for (const material of this.materials) material.dispose();
    this.materials = [];
    this.placed = [];
    this.faces = [];
  }

  private setLight(shape: Shape): void {
    const all = shape.lights;
    this.light = {
      ambient: { value: shape.ambient },
      kinds: { value: Int32Array.from(all, (l) => KINDS[l.kind]) },
      colors: { value: Float32Array.from(all.flatMap((l) => l.color)) },
      falloffs: { value: Float32Array.from(all.flatMap((l) => l.falloff)) },
      cones: { value: Float32Array.from(all.flatMap((l) => l.cone)) },
      positions: { value: null },
      directions: { value: null },
    };
    const [r, g, b, a] = shape.background;
    const color = a > 0 ? [r, g, b].map((v) => encoded(v / a)) : [0, 0, 0];
    this.renderer.setClearColor(new three.Color().setRGB(color[0]!, color[1]!, color[2]!), a);
  }

  private geometryOf(surface: Surface): three.BufferGeometry {
    const known = this.geometries.get(surface);
    if (known) return known;
    const geometry = new three.BufferGeometry()
      .setAttribute("position", new three.BufferAttribute(surface.positions, 3))
      .setAttribute("normal", new three.BufferAttribute(surface.normals, 4, true))
      .setIndex(new three.BufferAttribute(surface.indices, 1));
    if (surface.colors) geometry.setAttribute("color", new three.BufferAttribute(surface.colors, 4, true));
    this.geometries.set(surface, geometry);
    return geometry;
  }

  /** Of the same buffers, what is seen. */
  private shownOf(surface: Surface): three.BufferGeometry {
    const all = this.geometryOf(surface);
    if (surface.nShown === surface.indices.length) return all;
    const geometry = new three.BufferGeometry().setIndex(all.index!);
    for (const [name, attribute] of Object.entries(all.attributes)) geometry.setAttribute(name, attribute);
    geometry.setDrawRange(0, surface.nShown);
    return geometry;
  }

  private material(options: Omit<three.RawShaderMaterialOptions, "glslVersion" | "side" | "defines">, part: ShapePart, colors: boolean): three.RawShaderMaterial {
    const defines = { PLANES: part.planes.length, LIGHTS: this.shape!.lights.length, ...(colors ? { COLORS: 1 } : {}) };
    const material = new three.RawShaderMaterial({ ...options, defines, glslVersion: three.GLSL3, side: three.DoubleSide });
    this.materials.push(material);
    return material;
  }

  private put(geometry: three.BufferGeometry, material: three.RawShaderMaterial, order: number): three.Mesh {
    const mesh = new three.Mesh(geometry, material);
    mesh.frustumCulled = false;
    mesh.matrixAutoUpdate = false;
    mesh.renderOrder = order;
    this.scene.add(mesh);
    return mesh;
  }

  private look(part: ShapePart): Uniforms {
    return { shading: { value: SHADINGS[part.shading] }, gloss: { value: part.light }, own: { value: part.color } };
  }

  private add({ part, surface }: DrawnPart): void {
    const map = composed(part.place, surface.place);
    const own: Uniforms = { map: { value: null }, turn: { value: null }, planes: { value: null } };
    const uniforms = { ...this.common, ...this.light, ...this.look(part), ...own };
    const material = this.material({ vertexShader: surfaceVertex, fragmentShader: surfaceFragment, uniforms }, part, surface.colors !== null);
    this.put(this.shownOf(surface), material, SURFACES_LAST);
    const outside = isMirrored(map) ? three.BackSide : three.FrontSide;
    this.placed.push({ part, surface, map, uniforms: own, count: null, material, outside });
  }

  private addFaces(): void {
    const volumes = new Set(this.placed.filter(({ part }) => part.solid).map(({ part }) => part.volume));
    let order = 0;
    for (const volume of volumes) {
      const parts = this.placed.filter(({ part }) => part.volume === volume);
      for (const placed of parts) placed.count = this.addCount(placed, order);
      this.faces.push({ parts, mesh: this.addFace(parts[0]!, order + 1) });
      order += 2;
    }
  }

  private addCount(placed: Placed, order: number): three.Mesh {
    const uniforms = { ...this.common, ...placed.uniforms };
    const material = this.material({
      vertexShader: surfaceVertex, fragmentShader: countFragment, uniforms, colorWrite: false, depthTest: false, depthWrite: false,
      stencilWrite: true, stencilFunc: three.AlwaysStencilFunc, stencilZPass: three.InvertStencilOp,
    }, placed.part, false);
    return this.put(this.geometryOf(placed.surface), material, order);
  }

  private addFace({ part, uniforms: own }: Placed, order: number): three.Mesh {
    const uniforms = { ...this.common, ...this.light, ...this.look(part), planes: own["planes"]! };
    const material = this.material({
      vertexShader: faceVertex, fragmentShader: faceFragment, uniforms, stencilWrite: true, stencilFunc: three.NotEqualStencilFunc,
      stencilRef: 0, stencilZPass: three.ZeroStencilOp, stencilZFail: three.ZeroStencilOp, // clean for the next volume
    }, part, false);
    return this.put(this.everything, material, order);
  }

  /** One frame, at once. */
  draw(view: View): void {
    if (!this.shape) return;
    const lens = lensOf(view, this.canvas.width, this.canvas.height);
    let [near, far] = [Infinity, 0];
    for (const { map, surface, uniforms, part } of this.placed) {
      const eye = toEye(lens, map);
      if (surface.indices.length) {
        const [first, last] = depthsOf(eye, surface.lo, surface.hi);
        [near, far] = [Math.min(near, first), Math.max(far, last)];
      }
      uniforms["map"]!.value = [0, 1, 2, 3].flatMap((c) => [eye[3 * c]!, eye[3 * c + 1]!, eye[3 * c + 2]!, c === 3 ? 1 : 0]);
      uniforms["turn"]!.value = covectors(eye);
      uniforms["planes"]!.value = Float32Array.from(part.planes.flatMap((plane) => seenPlane(lens, plane)));
    }
    this.common["clip"]!.value = projection(lens, near, far);
    this.common["parallel_"]!.value = lens.parallel;
    this.common["half_"]!.value = [lens.halfWidth, lens.halfHeight];
    this.turnLight(lens);
    this.chooseFaces(near);
    this.renderer.render(this.scene, this.camera);
  }

  private turnLight(lens: Lens): void {
    const all = this.shape!.lights;
    const fixed = (kind: string) => kind === "camera";
    this.light["positions"]!.value = Float32Array.from(all.flatMap((l) => (fixed(l.frame) ? l.position : seenFrom(lens, l.position))));
    this.light["directions"]!.value = Float32Array.from(all.flatMap((l) => (fixed(l.frame) ? l.direction : turned(lens, l.direction))));
  }

  /** Nothing is cut open where no plane cuts and the eye is outside. */
  private chooseFaces(near: number): void {
    for (const { parts, mesh } of this.faces) {
      const open = parts[0]!.part.planes.length > 0 || near <= 0;
      mesh.visible = open;
      for (const { count, material, outside } of parts) {
        if (count) count.visible = open;
        material.side = open || parts.length > 1 ? three.DoubleSide : outside; // half as much to do
      }
    }
  }

  /** Milliseconds that a frame takes, to its last pixel; the page goes on meanwhile. */
  async measure(view: View): Promise<number> {
    this.draw(view); // shaders are made at the first one
    await this.done();
    const begin = performance.now();
    this.draw(view);
    await this.done();
    return performance.now() - begin;
  }

  /** When all that was asked for is drawn, or the graphics card is gone. */
  private async done(): Promise<void> {
    const gl = this.renderer.getContext();
    const sync = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    while (sync && !gl.isContextLost() && gl.getSyncParameter(sync, gl.SYNC_STATUS) !== gl.SIGNALED)
      await new Promise((resolve) => setTimeout(resolve, 1));
    gl.deleteSync(sync);
  }
}
