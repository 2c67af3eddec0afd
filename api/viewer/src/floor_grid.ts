// The squares on the floor, drawn by a shader on one plane: lines stay crisp near, thin out far away, and never end under the
// figure. (Long lines as geometry vanish in some software renderers once they pass behind the camera.)
import { Color, Mesh, PlaneGeometry, ShaderMaterial, Vector2 } from 'three';
import { themeColour } from './theme';

const SIZE_M = 60;

export class FloorGrid {
  readonly object: Mesh<PlaneGeometry, ShaderMaterial>;

  constructor() {
    const material = new ShaderMaterial({
      transparent: true,
      depthWrite: false,
      uniforms: { fine: { value: new Color() }, coarse: { value: new Color() }, middle: { value: new Vector2() } },
      vertexShader: `
        varying vec2 floorAt;
        void main() {
          vec4 world = modelMatrix * vec4(position, 1.0);
          floorAt = world.xz;
          gl_Position = projectionMatrix * viewMatrix * world;
        }`,
      fragmentShader: `
        uniform vec3 fine, coarse;
        uniform vec2 middle;
        varying vec2 floorAt;
        // How much of this pixel lies on a line of a grid; a grid finer than the pixels fades away.
        float lines(float period, float width) {
          vec2 pixel = fwidth(floorAt);
          vec2 off = abs(fract(floorAt / period - 0.5) - 0.5) * period;
          vec2 covered = 1.0 - smoothstep(vec2(width * 0.5), width * 0.5 + pixel * 1.2, off);
          covered *= clamp(1.6 - pixel * 4.0 / period, vec2(0.0), vec2(1.0));
          return max(covered.x, covered.y);
        }
        void main() {
          float near = 1.0 - smoothstep(6.0, 20.0, distance(floorAt, middle));
          float thin = lines(1.0, 0.008);
          float thick = lines(5.0, 0.022);
          gl_FragColor = vec4(mix(fine, coarse, thick), max(thin, thick) * near);
          #include <colorspace_fragment>
        }`,
    });
    this.object = new Mesh(new PlaneGeometry(SIZE_M, SIZE_M).rotateX(-Math.PI / 2), material);
    this.object.renderOrder = -2;
    this.recolour();
  }

  recolour(): void {
    this.object.material.uniforms.fine.value.set(themeColour('--grid-fine'));
    this.object.material.uniforms.coarse.value.set(themeColour('--grid-coarse'));
  }

  /** Brings the plane under the figure; the lines stay where they are. */
  centre(x: number, z: number): void {
    this.object.position.set(x, 0, z);
    this.object.material.uniforms.middle.value.set(x, z);
  }
}
