/** A cross in the cloud at the place that one points at in a picture. */
import { CanvasTexture, Sprite, SpriteMaterial, type Group } from 'three';
import type { Vec } from '../cloud/pick';

const SIZE = 64;
/** Of the height of the view. */
const SHARE = 0.045;

export class PlaceMarker {
  private readonly sprite: Sprite;

  constructor(private readonly room: Group) {
    const map = new CanvasTexture(cross());
    const material = new SpriteMaterial({
      map,
      depthTest: false,
      sizeAttenuation: false,
      transparent: true,
    });
    this.sprite = new Sprite(material);
    this.sprite.scale.setScalar(SHARE);
    this.sprite.renderOrder = 90;
    this.sprite.visible = false;
    room.parent?.add(this.sprite);
  }

  /** At a place in local coordinates; null: nowhere. */
  show(place: Vec | null): void {
    this.sprite.visible = place !== null;
    if (place) this.sprite.position.set(...place).applyMatrix4(this.room.matrix);
  }
}

function cross(): HTMLCanvasElement {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = SIZE;
  const pen = canvas.getContext('2d')!;
  const middle = SIZE / 2;
  for (const [width, colour] of [
    [7, '#0b0e12'],
    [3, '#ffffff'],
  ] as const) {
    pen.lineWidth = width;
    pen.strokeStyle = colour;
    pen.beginPath();
    pen.arc(middle, middle, 18, 0, 2 * Math.PI);
    for (const [x, y] of [
      [1, 0],
      [-1, 0],
      [0, 1],
      [0, -1],
    ] as const) {
      pen.moveTo(middle + 10 * x, middle + 10 * y);
      pen.lineTo(middle + 28 * x, middle + 28 * y);
    }
    pen.stroke();
  }
  return canvas;
}
