// SPDX-License-Identifier: GPL-2.0-or-later
// wiregasm's script without `new Function`, which the page's policy forbids. What it makes with it are small functions
// around those of C++; here they are closures.

const NAMED = `function createNamedFunction(name, body) {
      return Object.defineProperty(function () { return body.apply(this, arguments); }, "name", { value: name });
    }
  `;

const INVOKER = `function craftInvokerFunction(humanName, argTypes, classType, invoker, fn) {
      var isMethod = argTypes[1] !== null && classType !== null, [returned, self, ...wanted] = argTypes;
      return function (...given) {
        if (given.length !== wanted.length) {
          throwBindingError("function " + humanName + " called with " + given.length + " arguments, expected " + wanted.length);
        }
        var destructors = [];
        var wired = isMethod ? [self.toWireType(destructors, this)] : [];
        given.forEach((argument, place) => wired.push(wanted[place].toWireType(destructors, argument)));
        var result = invoker(fn, ...wired);
        runDestructors(destructors);
        return returned.name === "void" ? undefined : returned.fromWireType(result);
      };
    }
  `;

const REPLACED = [
  [/function createNamedFunction\(name, body\) \{[^]*?(?=function extendError)/, NAMED],
  [/function craftInvokerFunction\([^]*?(?=function __embind_register_class_constructor\()/, INVOKER],
];

export function withoutEval(script) {
  let made = script;
  for (const [pattern, ours] of REPLACED) {
    if (!pattern.test(made)) throw new Error(`wiregasm.js has no ${pattern}: does wiregasm.mjs fit this version?`);
    made = made.replace(pattern, () => ours);
  }
  if (/new Function|\beval\(/.test(made)) throw new Error("wiregasm.js still makes code from text");
  return made;
}
