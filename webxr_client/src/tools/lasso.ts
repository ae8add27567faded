/** The lasso: an outline drawn over the picture. */
const NS = 'http://www.w3.org/2000/svg';
/** A corner every few pixels is as fine as a hand draws. */
const STEP = 3;

export class LassoOutline {
  private readonly svg = document.createElementNS(NS, 'svg');
  private readonly line = document.createElementNS(NS, 'polygon');
  private corners: [number, number][] = [];

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.svg.classList.add('lasso');
    const { style } = this.svg;
    style.position = 'absolute';
    style.inset = '0';
    style.width = '100%';
    style.height = '100%';
    style.pointerEvents = 'none';
    this.svg.append(this.line);
    this.line.setAttribute('stroke-width', '1.5');
    this.line.setAttribute('stroke-dasharray', '5 4');
    this.line.setAttribute('fill-opacity', '0.12');
  }

  begin(x: number, y: number, color: string): void {
    this.corners = [[x, y]];
    this.line.setAttribute('stroke', color);
    this.line.setAttribute('fill', color);
    this.line.setAttribute('points', '');
    this.canvas.parentElement?.append(this.svg);
  }

  add(x: number, y: number): void {
    const last = this.corners.at(-1);
    if (last && Math.hypot(x - last[0], y - last[1]) < STEP) return;
    this.corners.push([x, y]);
    this.line.setAttribute('points', this.corners.map((corner) => corner.join(',')).join(' '));
  }

  /** Give it up. */
  cancel(): void {
    this.svg.remove();
    this.corners = [];
  }

  /** The outline in normalised device coordinates, or null when it encloses nothing. */
  end(): [number, number][] | null {
    this.svg.remove();
    if (this.corners.length < 3) return null;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const step = Math.ceil(this.corners.length / 4000);
    return this.corners
      .filter((_, i) => i % step === 0)
      .map(([x, y]) => [(x / width) * 2 - 1, 1 - (y / height) * 2]);
  }
}
