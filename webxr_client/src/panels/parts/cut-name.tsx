/** A name that is cut in its middle, because its end, usually a number, distinguishes it. */

/** The last word of a name, with the space before it, when it is short enough to stay. */
const END = /^(.*\S)(\s+\S{1,5})$/u;

export function CutName({ name }: { name: string }) {
  const [, start, end] = END.exec(name) ?? [];
  if (!start || !end) return <span class="name">{name}</span>;
  return (
    <span class="name parted">
      <span class="name">{start}</span>
      <span class="end-of-name">{end}</span>
    </span>
  );
}
