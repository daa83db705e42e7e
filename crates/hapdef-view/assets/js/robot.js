// The page of a robot: each limb's page in a frame, with the token of the address.

for (const frame of document.querySelectorAll("iframe[data-limb]")) {
  frame.src = `limb/${frame.dataset.limb}/${location.hash}`;
}
for (const link of document.querySelectorAll("a[data-limb]")) {
  link.href = `limb/${link.dataset.limb}/${location.hash}`;
}
