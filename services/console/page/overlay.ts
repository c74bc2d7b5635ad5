// What moves over the picture of a block: where the machine has its focus, the beam above the
// newest crack, and the points that come next. The picture below is added to and not drawn again
// for them.
import * as THREE from 'three';
import { Cloud } from './cloud';

const nextPoints = 60;
const shownMs = 5000;    // since the newest crack
const aboveBlock = 0.2;  // where the beam begins, in parts of the longest side
const halfWidth = 0.012;

type Pixel = [number, number];

export class Overlay {
  private context: CanvasRenderingContext2D;

  constructor(private canvas: OffscreenCanvas, width: number, height: number) {
    this.context = canvas.getContext('2d');
    this.resize(width, height);
  }

  resize(width: number, height: number) {
    this.canvas.width = width;
    this.canvas.height = height;
  }

  /** `focusMm`: in the glass; undefined: it is not known. `cut`: only what the section leaves,
   * as in Look (cloud.ts). */
  draw(cloud: Cloud | undefined, focusMm: number[] | undefined, cut: number[],
       camera: THREE.PerspectiveCamera) {
    const { width, height } = this.canvas;
    this.context.clearRect(0, 0, width, height);
    if (!cloud) return;
    const pixel = (at: THREE.Vector3): Pixel => {
      const { x, y } = at.project(camera);
      return [(x + 1) / 2 * width, (1 - y) / 2 * height];
    };
    if (focusMm) {
      const focus = cloud.placeOf(focusMm);
      const above = Math.max(focus.z, cloud.sides[2] / 2) + aboveBlock;
      this.drawFocus(pixel(new THREE.Vector3().set(focus.x, focus.y, above)), pixel(focus));
    }
    if (cloud.newest < 0 || performance.now() - cloud.newestAt > shownMs) return;
    this.drawNext(cloud.following(nextPoints).filter((place) => cloud.isWithin(place, cut))
      .map((place) => pixel(cloud.at(place))));
    if (!cloud.isWithin(cloud.newest, cut)) return;
    const focus = cloud.at(cloud.newest);
    const top = (aside: number) => new THREE.Vector3().set(
      focus.x + aside, focus.y, cloud.sides[2] / 2 + aboveBlock);
    this.drawBeam([pixel(top(-halfWidth)), pixel(top(halfWidth)), pixel(focus)]);
  }

  private drawFocus(above: Pixel, focus: Pixel) {
    this.context.strokeStyle = '#4dff66';
    this.context.lineWidth = 1.5;
    this.context.beginPath();
    this.context.moveTo(...above);
    this.context.lineTo(...focus);
    this.context.stroke();
    this.context.beginPath();
    this.context.arc(...focus, 7, 0, 2 * Math.PI);
    this.context.stroke();
  }

  private drawNext(points: Pixel[]) {
    this.context.fillStyle = '#00e5ff';
    for (const [x, y] of points) this.context.fillRect(x - 1, y - 1, 2, 2);
  }

  private drawBeam(corners: Pixel[]) {
    this.context.beginPath();
    for (const [x, y] of corners) this.context.lineTo(x, y);
    this.context.closePath();
    this.context.fillStyle = '#ff4f4f';
    this.context.globalAlpha = 0.5;
    this.context.fill();
    this.context.globalAlpha = 1;
    const [x, y] = corners[corners.length - 1];
    this.context.beginPath();
    this.context.arc(x, y, 3.5, 0, 2 * Math.PI);
    this.context.fill();
  }
}
