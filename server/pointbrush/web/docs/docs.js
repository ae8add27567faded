// Renders the OpenAPI as a plain page: no library, nothing fetched from elsewhere.
'use strict';

const VERBS = ['get', 'post', 'put', 'patch', 'delete'];

function element(tag, text, className) {
  const node = document.createElement(tag);
  if (text !== undefined) node.textContent = text;
  if (className) node.className = className;
  return node;
}

function resolve(schema, root, depth = 0) {
  if (Array.isArray(schema)) return schema.map((item) => resolve(item, root, depth));
  if (schema === null || typeof schema !== 'object') return schema;
  if (schema.$ref && depth < 6) {
    const target = schema.$ref.split('/').slice(1).reduce((node, key) => node?.[key], root);
    return resolve(target, root, depth + 1);
  }
  return Object.fromEntries(
    Object.entries(schema).map(([key, value]) => [key, resolve(value, root, depth)]),
  );
}

function table(rows, head) {
  const out = element('table');
  const top = element('tr');
  for (const text of head) top.append(element('th', text));
  out.append(top);
  for (const row of rows) {
    const line = element('tr');
    for (const text of row) line.append(element('td', text));
    out.append(line);
  }
  return out;
}

function schemaBlock(title, content, root) {
  const out = element('div');
  for (const [type, { schema }] of Object.entries(content ?? {})) {
    out.append(element('h4', `${title}: ${type}`));
    if (schema) out.append(element('pre', JSON.stringify(resolve(schema, root), null, 2)));
  }
  return out;
}

function call(path, verb, operation, root) {
  const out = element('details');
  const summary = element('summary');
  summary.append(element('code', verb.toUpperCase(), 'verb'), element('code', path));
  summary.append(element('span', ` ${operation.summary ?? ''}`, 'about'));
  const body = element('div');
  body.append(element('p', operation.description ?? ''));
  if (operation.parameters?.length) {
    const rows = operation.parameters.map((parameter) => [
      parameter.name,
      parameter.in,
      parameter.required ? 'required' : '',
      JSON.stringify(resolve(parameter.schema, root)),
    ]);
    body.append(table(rows, ['Parameter', 'In', '', 'Schema']));
  }
  body.append(schemaBlock('Body', operation.requestBody?.content, root));
  for (const [status, response] of Object.entries(operation.responses)) {
    if (status.startsWith('2')) body.append(schemaBlock(`Answer ${status}`, response.content, root));
  }
  const rows = Object.entries(operation.responses).map(([status, r]) => [status, r.description]);
  body.append(table(rows, ['Status', 'Means']));
  out.append(summary, body);
  return out;
}

function show(root) {
  document.getElementById('about').textContent = `${root.info.description} Version ${root.info.version}.`;
  const main = document.getElementById('calls');
  const contents = document.getElementById('contents');
  main.replaceChildren();
  const sections = new Map();
  for (const [path, item] of Object.entries(root.paths)) {
    for (const verb of VERBS.filter((name) => item[name])) {
      const tag = item[verb].tags?.[0] ?? 'other';
      if (!sections.has(tag)) {
        const section = element('section');
        section.id = tag;
        section.append(element('h2', tag));
        sections.set(tag, section);
        const link = element('a', tag);
        link.href = `#${tag}`;
        contents.append(link);
        main.append(section);
      }
      sections.get(tag).append(call(path, verb, item[verb], root));
    }
  }
}

fetch('/api/v1/openapi.json')
  .then((response) => response.json())
  .then(show)
  .catch((error) => {
    document.getElementById('calls').textContent = `The description could not be loaded: ${error}`;
  });
