import type { Entry } from '../../drawing/ui';

/** The reason why everything that changes labels is disabled. */
export const VIEWER = 'Your role cannot change labels.';

/** The part of a list that is in sight, and the buttons that turn it. */
export class Rows {
  private first = 0;

  constructor(
    private readonly touch: () => void,
    /** Entries that are in sight. */
    private readonly most: number,
  ) {}

  /** The part of a list that is in sight. */
  of<Item>(list: readonly Item[]): Item[] {
    this.first = Math.min(this.first, Math.max(0, list.length - this.most));
    return list.slice(this.first, this.first + this.most);
  }

  /** Bring an entry into sight. */
  show(place: number): void {
    this.first = Math.min(place, Math.max(this.first, place - this.most + 1));
  }

  /** Buttons of a strip that turn a list of so many entries. */
  turning(entries: number): Entry[] {
    const disabled = entries <= this.most;
    const turn = (by: number) => () => {
      this.first = Math.max(0, this.first + by);
      this.touch();
    };
    return [
      [{ icon: 'previous', disabled }, turn(-this.most)],
      [{ icon: 'next', disabled }, turn(this.most)],
    ];
  }
}
