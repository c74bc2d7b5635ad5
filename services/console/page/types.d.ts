// What TypeScript 4.8 of Debian does not know: of browsers, and of three.js r111, which has no
// types there. Only what the page uses, so that a wrong name is found.
// Can be transferred to a worker, as an ImageBitmap.
interface OffscreenCanvas extends ImageBitmap {
  width: number;
  height: number;
  getContext(kind: '2d'): CanvasRenderingContext2D;
}
interface HTMLCanvasElement {
  transferControlToOffscreen(): OffscreenCanvas;
}

declare module 'three' {
  export class Vector3 {
    x: number;
    y: number;
    z: number;
    set(x: number, y: number, z: number): this;
    clone(): Vector3;
    negate(): this;
    project(camera: PerspectiveCamera): this;
  }
  export class Object3D {
    position: Vector3;
    scale: Vector3;
    up: Vector3;
    frustumCulled: boolean;
    visible: boolean;
    add(...objects: Object3D[]): this;
    remove(object: Object3D): this;
    lookAt(x: number, y: number, z: number): void;
  }
  export class Group extends Object3D {}
  export class Scene extends Object3D {}
  export class Box3 {
    constructor(min: Vector3, max: Vector3);
  }
  export class Box3Helper extends Object3D {
    constructor(box: Box3, color: number);
  }
  export class PerspectiveCamera extends Object3D {
    constructor(fov: number, aspect: number, near: number, far: number);
    aspect: number;
    updateProjectionMatrix(): void;
    updateMatrixWorld(): void;
  }
  export const DynamicDrawUsage: number;
  export class BufferAttribute {
    constructor(array: Float32Array | Uint8Array | Uint16Array, size: number,
                normalized?: boolean);
    needsUpdate: boolean;
    setUsage(usage: number): this;
  }
  export class BufferGeometry {
    setAttribute(name: string, attribute: BufferAttribute): this;
    setDrawRange(start: number, count: number): void;
    dispose(): void;
  }
  export class RawShaderMaterial {
    constructor(parameters: {
      transparent: boolean;
      depthWrite: boolean;
      uniforms: Record<string, { value: any }>;
      vertexShader: string;
      fragmentShader: string;
    });
    uniforms: Record<string, { value: any }>;
  }
  export class Points extends Object3D {
    constructor(geometry: BufferGeometry, material: RawShaderMaterial);
    geometry: BufferGeometry;
  }
  export class WebGLRenderer {
    constructor(parameters: {
      canvas: OffscreenCanvas;
      antialias: boolean;
      preserveDrawingBuffer: boolean;
      depth: boolean;
      stencil: boolean;
    });
    autoClear: boolean;
    getContext(): WebGLRenderingContext;
    clear(): void;
    setSize(width: number, height: number, style: boolean): void;
    render(scene: Scene, camera: PerspectiveCamera): void;
  }
}
