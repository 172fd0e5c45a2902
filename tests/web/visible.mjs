// Lists words that scripts show without having them translated: code comes as JSON, by its name.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const { Linter } = createRequire(`${process.argv[2]}/`)("eslint");
const READ = /^(aria-label|aria-valuetext|placeholder|title|label|alt)$/;
const FIRST = { write: 1, html: 2, svg: 2, text: 2, section: 0, key: 0, column: 0 }; // argument that is shown, and those behind it

/** Returns the words in an expression that is shown, without those that are said. */
function* wordsOf(node) {
  if (node.type === "Literal" && typeof node.value === "string") yield [node, node.value];
  if (node.type === "TemplateLiteral") {
    for (const part of node.quasis) yield [node, part.value.cooked];
    for (const part of node.expressions) yield* wordsOf(part);
  }
  if (node.type === "ConditionalExpression") for (const part of [node.consequent, node.alternate]) yield* wordsOf(part);
  if (node.type === "LogicalExpression") for (const part of [node.left, node.right]) yield* wordsOf(part);
  if (node.type === "ArrayExpression") for (const part of node.elements) if (part) yield* wordsOf(part);
}

const rule = {
  create: (context) => {
    const look = (node) => {
      for (const [at, words] of wordsOf(node)) {
        if (/[A-Za-z]{2}/.test(words)) context.report({ node: at, message: context.sourceCode.getText(at) });
      }
    };
    return {
      CallExpression({ callee, arguments: given }) {
        const name = callee.name ?? callee.property?.name;
        if (name in FIRST && callee.type === "Identifier") given.slice(FIRST[name]).forEach(look);
        if (name === "setAttribute" && READ.test(given[0]?.value) && given[1]) look(given[1]);
      },
      Property({ key, value }) {
        if (READ.test(key.value ?? key.name)) look(value);
      },
      AssignmentExpression({ left, right }) {
        if (/^(textContent|title|placeholder)$/.test(left.property?.name)) look(right);
      },
    };
  },
};

const config = [{ plugins: { own: { rules: { visible: rule } } }, rules: { "own/visible": "error" } }];
const found = [];
for (const [name, code] of Object.entries(JSON.parse(readFileSync(0, "utf8")))) {
  for (const { message } of new Linter().verify(code, config)) found.push([name, message]);
}
process.stdout.write(JSON.stringify(found));
