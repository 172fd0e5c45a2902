// Lists where scripts decide on a text that is meant for people: code comes as JSON, by its name.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const { Linter } = createRequire(`${process.argv[2]}/`)("eslint");
const TEXTS = /^(text|texts|words|says|said|told|why|who|reason|reasons|refusal|remark|line|lines|listing)$/;
const LOOKS = /^(startsWith|endsWith|includes|indexOf|lastIndexOf|match|matchAll|search|replace|replaceAll|split)$/;

/** Returns the name of what an expression reads, "" for none. */
function nameOf(node) {
  if (node?.type === "Identifier") return node.name;
  if (node?.type === "MemberExpression") return nameOf(node.computed ? node.object : node.property);
  if (node?.type === "ChainExpression") return nameOf(node.expression);
  if (node?.type === "CallExpression") return nameOf(node.callee.object);
  return "";
}

const isText = (node) => TEXTS.test(nameOf(node));
const isWording = (node) =>
  Boolean(node?.regex) ||
  (node?.type === "Literal" && typeof node.value === "string" && /[A-Za-z]/.test(node.value)) ||
  node?.type === "TemplateLiteral" ||
  (node?.type === "Identifier" && /^[A-Z][A-Z_]*$/.test(node.name));

const rule = {
  create: (context) => {
    const report = (node) => context.report({ node, message: context.sourceCode.getText(node) });
    return {
      CallExpression(node) {
        const { callee } = node;
        if (callee.type !== "MemberExpression") return;
        const [asked, given] = [callee.property.name, node.arguments[0]];
        if (LOOKS.test(asked) && isText(callee.object) && isWording(given)) report(node);
        if (/^(test|exec)$/.test(asked) && isText(given)) report(node);
        if (/^(includes|indexOf|has|get)$/.test(asked) && isText(given) && isWording(callee.object)) report(node);
      },
      BinaryExpression(node) {
        const { left, right, operator } = node;
        const sides = (isText(left) && isWording(right)) || (isText(right) && isWording(left));
        if (/^[!=]==?$/.test(operator) && sides) report(node);
        if (operator === "in" && isText(left)) report(node);
      },
      SwitchStatement(node) {
        if (isText(node.discriminant)) report(node.discriminant);
      },
    };
  },
};

const config = [{ plugins: { own: { rules: { english: rule } } }, rules: { "own/english": "error" } }];
const found = [];
for (const [name, code] of Object.entries(JSON.parse(readFileSync(0, "utf8")))) {
  for (const { message } of new Linter().verify(code, config)) found.push([name, message]);
}
process.stdout.write(JSON.stringify(found));
