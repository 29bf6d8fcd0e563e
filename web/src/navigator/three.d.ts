/** What is used of three.js, which has no types of its own. */
declare module "three" {
  export interface WebGLRendererOptions {
    canvas: HTMLCanvasElement;
    antialias?: boolean;
    alpha?: boolean;
    stencil?: boolean;
    powerPreference?: "high-performance" | "low-power" | "default";
  }
  export class WebGLRenderer {
    constructor(options: WebGLRendererOptions);
    outputColorSpace: string;
    setSize(width: number, height: number, style: boolean): void;
    setClearColor(color: Color, alpha: number): void;
    render(scene: Scene, camera: Camera): void;
    getContext(): WebGL2RenderingContext;
    dispose(): void;
  }
  export const LinearSRGBColorSpace: string;
  export const ColorManagement: { enabled: boolean };
  export class Color {
    setRGB(red: number, green: number, blue: number): this;
  }
  export class Camera {}
  export class Scene {
    matrixWorldAutoUpdate: boolean;
    add(object: Mesh): this;
    clear(): this;
  }
  export class BufferAttribute {
    constructor(array: ArrayBufferView, itemSize: number, normalized?: boolean);
  }
  export class BufferGeometry {
    setAttribute(name: string, attribute: BufferAttribute): this;
    setIndex(index: BufferAttribute): this;
    setDrawRange(first: number, count: number): void;
    readonly attributes: { [name: string]: BufferAttribute };
    readonly index: BufferAttribute | null;
    dispose(): void;
  }
  export class Mesh {
    constructor(geometry: BufferGeometry, material: RawShaderMaterial);
    renderOrder: number;
    visible: boolean;
    frustumCulled: boolean;
    matrixAutoUpdate: boolean;
  }
  export interface Uniform {
    value: unknown;
  }
  export interface RawShaderMaterialOptions {
    glslVersion: string;
    vertexShader: string;
    fragmentShader: string;
    defines: { [name: string]: number | string };
    uniforms: { [name: string]: Uniform };
    side: number;
    colorWrite?: boolean;
    depthTest?: boolean;
    depthWrite?: boolean;
    stencilWrite?: boolean;
    stencilFunc?: number;
    stencilRef?: number;
    stencilZPass?: number;
    stencilZFail?: number;
  }
  export class RawShaderMaterial {
    constructor(options: RawShaderMaterialOptions);
    uniforms: { [name: string]: Uniform };
    side: number;
    dispose(): void;
  }
  export const GLSL3: string;
  export const DoubleSide: number;
  export const FrontSide: number;
  export const BackSide: number;
  export const AlwaysStencilFunc: number;
  export const NotEqualStencilFunc: number;
  export const InvertStencilOp: number;
  export const ZeroStencilOp: number;
}
