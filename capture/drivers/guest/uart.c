// SPDX-License-Identifier: GPL-2.0-or-later
/* A 16550A without wires, for the driver 8250: each character has its own line status, as in the FIFO of a
 * real one.
 *
 * Write to /dev/uart: two bytes a character, value and line status. 0x02 means that one was lost before it.
 * Read from it: what the driver has written to the registers.
 */

#include <linux/fs.h>
#include <linux/miscdevice.h>
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/serial_8250.h>
#include <linux/serial_core.h>
#include <linux/serial_reg.h>
#include <linux/uaccess.h>

#define FIFO   16
#define LOGGED 65536

static const int triggers[] = {1, 4, 8, 14};

struct written {
    u64 ns;
    u8 reg, value, unused[6];
};

static DEFINE_SPINLOCK(lock);
static struct uart_port *port; /* as the driver has it */
static u8 values[FIFO], status[FIFO], registers[8], divisor[2];
static int first, count, trigger = 1;
static u8 overrun;
static struct written logged[LOGGED];
static unsigned int written;

static bool
wants_characters(void)
{
    return count && registers[UART_IER] & UART_IER_RDI;
}

static u8
why(void)
{
    if (overrun && registers[UART_IER] & UART_IER_RLSI)
        return UART_IIR_RLSI;
    if (wants_characters())
        return count >= trigger ? UART_IIR_RDI : UART_IIR_RX_TIMEOUT;
    return registers[UART_IER] & UART_IER_THRI ? UART_IIR_THRI : UART_IIR_NO_INT;
}

static u8
line_status(void)
{
    u8 found = UART_LSR_TEMT | UART_LSR_THRE | overrun;

    overrun = 0;
    if (count) {
        found |= UART_LSR_DR | status[first];
        status[first] = 0;
    }
    return found;
}

static u8
character(void)
{
    u8 value = values[first];

    if (!count)
        return 0;
    first = (first + 1) % FIFO;
    count--;
    return value;
}

static unsigned int
read_register(struct uart_port *of, int reg)
{
    unsigned long flags;
    u8 value;

    port = of;
    spin_lock_irqsave(&lock, flags);
    if (reg < 2 && registers[UART_LCR] & UART_LCR_DLAB)
        value = divisor[reg];
    else if (reg == UART_RX)
        value = character();
    else if (reg == UART_IIR)
        value = why() | 0xc0; /* it has a FIFO */
    else if (reg == UART_LSR)
        value = line_status();
    else if (reg == UART_MSR)
        value = UART_MSR_DCD | UART_MSR_DSR | UART_MSR_CTS;
    else
        value = registers[reg];
    spin_unlock_irqrestore(&lock, flags);
    return value;
}

static void
write_register(struct uart_port *of, int reg, int value)
{
    unsigned long flags;

    spin_lock_irqsave(&lock, flags);
    if (reg < 2 && registers[UART_LCR] & UART_LCR_DLAB) {
        divisor[reg] = value;
    } else if (reg == UART_FCR) {
        trigger = value & UART_FCR_ENABLE_FIFO ? triggers[value >> 6 & 3] : 1;
        if (value & UART_FCR_CLEAR_RCVR)
            count = 0;
    } else {
        registers[reg] = value;
    }
    if (written < LOGGED)
        logged[written++] = (struct written){ktime_get_ns(), reg, value};
    spin_unlock_irqrestore(&lock, flags);
}

/* A character comes in; return whether the UART now interrupts. */
static bool
arrives(u8 value, u8 line)
{
    unsigned long flags;
    bool interrupts;

    spin_lock_irqsave(&lock, flags);
    if (line & UART_LSR_OE || count == FIFO)
        overrun = UART_LSR_OE;
    if (count < FIFO) {
        int last = (first + count++) % FIFO;

        values[last] = value;
        status[last] = line & ~UART_LSR_OE;
    }
    interrupts = wants_characters() && count >= trigger;
    spin_unlock_irqrestore(&lock, flags);
    return interrupts;
}

static ssize_t
play(struct file *file, const char __user *from, size_t size, loff_t *unused)
{
    u8 one[2];
    size_t at;

    for (at = 0; at + 1 < size; at += 2) {
        if (copy_from_user(one, from + at, 2))
            return -EFAULT;
        if (arrives(one[0], one[1]))
            serial8250_handle_irq(port, UART_IIR_RDI);
    }
    if (wants_characters())
        serial8250_handle_irq(port, UART_IIR_RX_TIMEOUT);
    return size;
}

static ssize_t
told(struct file *file, char __user *to, size_t size, loff_t *from)
{
    return simple_read_from_buffer(to, size, from, logged, written * sizeof(*logged));
}

static const struct file_operations operations = {
    .owner = THIS_MODULE, .write = play, .read = told, .llseek = default_llseek};
static struct miscdevice control = {.minor = MISC_DYNAMIC_MINOR, .name = "uart", .fops = &operations};

static int __init
begin(void)
{
    struct platform_device *device = platform_device_register_simple("uart", -1, NULL, 0);
    struct uart_8250_port uart = {};
    int line;

    if (IS_ERR(device))
        return PTR_ERR(device);
    uart.port.dev = &device->dev;
    uart.port.iotype = UPIO_PORT;
    uart.port.iobase = 0x5c0; /* never accessed */
    uart.port.uartclk = 1843200;
    uart.port.type = PORT_16550A;
    uart.port.flags = UPF_FIXED_TYPE | UPF_SKIP_TEST;
    uart.port.fifosize = uart.tx_loadsz = FIFO;
    uart.port.serial_in = read_register;
    uart.port.serial_out = write_register;
    line = serial8250_register_8250_port(&uart);
    if (line < 0)
        return line;
    return misc_register(&control);
}
module_init(begin);
MODULE_DESCRIPTION("A 16550A without wires");
MODULE_LICENSE("GPL");
